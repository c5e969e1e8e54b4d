// A dialog that is a form: fields, one button that does it. It closes when that worked.
import { showWhy } from './api';
import { openDialog, type OpenDialog } from './dialog';
import { h } from './dom';
import type { Field } from './forms';
import { text } from './texts';

export interface FormDialog {
  title: string;
  explain?: string;
  fields: Field[];
  extra?: HTMLElement[]; // below the fields
  submit: string;
  dangerous?: boolean;
  // Shows what is wrong at a field and gives false, or true.
  check?: () => boolean;
  run: () => Promise<() => void>; // gives what says that it is done
}

export function openFormDialog(options: FormDialog, closed: () => void = () => undefined): OpenDialog {
  const failure = h('p', { class: 'form-error', role: 'alert' });
  const button = h('button', { type: 'submit', class: options.dangerous ? 'danger' : 'primary' }, options.submit);
  const cancel = h('button', { type: 'button', onclick: () => dialog.close() }, text('dialog.cancel'));
  const form = h('form', { novalidate: true, class: 'form' },
    options.explain ? h('p', {}, options.explain) : null,
    ...options.fields.map((field) => field.element),
    ...(options.extra ?? []),
    failure,
    h('div', { class: 'row' }, button, cancel));
  form.addEventListener('submit', (event) => {
    event.preventDefault();
    void submit();
  });
  options.fields[0]?.input.setAttribute('autofocus', '');
  const dialog = openDialog(options.title, [form], closed);
  return dialog;

  async function submit(): Promise<void> {
    options.fields.forEach((field) => field.clear());
    failure.textContent = '';
    if (button.getAttribute('aria-disabled') || options.check?.() === false) {
      return;
    }
    button.setAttribute('aria-disabled', 'true');
    try {
      const sayDone = await options.run();
      dialog.close();
      sayDone();
    } catch (error) {
      const field = options.fields[0];
      if (field) {
        field.fail(error);
      } else {
        showWhy(failure, error);
      }
    } finally {
      button.removeAttribute('aria-disabled');
    }
  }
}

// True where the field holds something; else says what is missing.
export function required(field: Field, missing: string): boolean {
  if (field.value() === '') {
    field.fail(missing);
    return false;
  }
  return true;
}
