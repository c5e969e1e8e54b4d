// What a thing is called that was shown, and who may ask for it.
import { openDialog } from '../shared/dialog';
import { h } from '../shared/dom';
import { selectField, textField } from '../shared/forms';
import { text } from '../shared/texts';

const kLongestBytes = 60;

export function openTeach(name: (thing: string, isPrivate: boolean) => void): void {
  const field = textField(text('teach.name'), {
    hint: text('teach.name_hint'), attributes: { enterkeyhint: 'done', autocapitalize: 'none', maxlength: kLongestBytes, autofocus: true },
  });
  const who = selectField(text('teach.who'), [
    { value: 'all', label: text('teach.all') }, { value: 'me', label: text('teach.me') },
  ]);
  field.input.addEventListener('input', () => field.clear());
  const form = h('form', { novalidate: true, class: 'choice-form' }, field.element, who.element,
    h('button', { type: 'submit', class: 'primary' }, text('teach.go')));
  form.addEventListener('submit', (event) => {
    event.preventDefault();
    const called = field.value();
    if (called === '') {
      field.fail(text('teach.missing'));
    } else if (new TextEncoder().encode(called).length > kLongestBytes) {
      field.fail(text('teach.long'));
    } else {
      dialog.close();
      name(called, who.value() === 'me');
    }
  });
  const dialog = openDialog(text('teach.title'), [form]);
}
