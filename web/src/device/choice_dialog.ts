// Choose one of a list, or type: for what to find, and how a room is called.
import { openDialog } from '../shared/dialog';
import { h } from '../shared/dom';
import { textField } from '../shared/forms';
import { counted } from '../shared/texts';
import { matching } from '../shared/filter';

export interface ChoiceTexts {
  title: string;
  label: string; // of the field
  go: string; // of the button beside it
  missing: string; // where nothing was typed
}

export function openChoice(texts: ChoiceTexts, choices: readonly string[], chosen: (choice: string) => void): void {
  const field = textField(texts.label, { attributes: { type: 'search', enterkeyhint: 'search' } });
  const list = h('ul', { class: 'choices' });
  const count = h('p', { class: 'hint', role: 'status' });
  const choose = (choice: string): void => {
    dialog.close();
    chosen(choice);
  };
  const show = (): void => {
    const found = matching(choices, field.value());
    list.textContent = '';
    for (const choice of found) {
      list.append(h('li', {},
        h('button', { type: 'button', class: 'choice', onclick: () => choose(choice) }, choice)));
    }
    count.textContent = counted('choice.found', found.length);
  };
  field.input.addEventListener('input', () => {
    field.clear();
    show();
  });
  const form = h('form', { novalidate: true, class: 'choice-form' }, field.element,
    h('button', { type: 'submit', class: 'primary' }, texts.go));
  form.addEventListener('submit', (event) => {
    event.preventDefault();
    if (field.value() === '') {
      field.fail(texts.missing);
    } else {
      choose(field.value());
    }
  });
  // A keyboard on the screen would hide the list: the field gets focus only where there is a real one.
  if (window.matchMedia('(hover: hover) and (pointer: fine)').matches) {
    field.input.setAttribute('autofocus', '');
  }
  show();
  const dialog = openDialog(texts.title, choices.length > 0 ? [form, count, list] : [form]);
}
