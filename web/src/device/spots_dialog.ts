// Places that somebody marks to be brought back to: mark this one, go back, rename and forget those that are marked.
import { openDialog } from '../shared/dialog';
import { h } from '../shared/dom';
import { textField } from '../shared/forms';
import { text } from '../shared/texts';
import { openChoice } from './choice_dialog';

const kLongest = 60; // characters

export interface SpotActions {
  mark: (name: string) => void; // empty: without a name
  back: () => void;
  rename: (spot: string, name: string) => void;
  forget: (spot: string) => void;
}

export function openSpots(spots: readonly string[], actions: SpotActions): void {
  const field = textField(text('spots.name'), {
    hint: text('spots.hint'), attributes: { enterkeyhint: 'done', autocapitalize: 'none', maxlength: kLongest },
  });
  const done = (run: () => void): void => {
    dialog.close();
    run();
  };
  const form = h('form', { novalidate: true, class: 'choice-form' }, field.element,
    h('button', { type: 'submit', class: 'primary' }, text('spots.mark')));
  form.addEventListener('submit', (event) => {
    event.preventDefault();
    done(() => actions.mark(field.value()));
  });
  const rename = (spot: string): void => openChoice({
    title: text('spots.rename', { name: spot }), label: text('spots.new_name'), go: text('spots.give'), missing: text('spots.missing'),
  }, [], (name) => actions.rename(spot, name));
  const choice = (label: string, run: () => void): HTMLElement =>
    h('li', {}, h('button', { type: 'button', class: 'choice', onclick: () => done(run) }, label));
  const list = h('ul', { class: 'choices' },
    choice(text('spots.back'), actions.back),
    ...spots.flatMap((spot) => [
      choice(text('spots.rename', { name: spot }), () => rename(spot)),
      choice(text('spots.forget', { name: spot }), () => actions.forget(spot)),
    ]));
  const dialog = openDialog(text('spots.title'), [form, list]);
}
