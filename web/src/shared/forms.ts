// Fields with a label, a hint and an error beside them that is read when it comes.
import { showWhy } from './api';
import { h, newId, type Attributes } from './dom';

export interface Field {
  element: HTMLElement;
  input: HTMLInputElement | HTMLSelectElement;
  value: () => string;
  fail: (why: unknown) => void; // words or an error: shows it, and goes there
  clear: () => void;
}

type TsdfOptions = { hint?: string; attributes?: Attributes; value?: string };

export function textField(label: string, options: TsdfOptions = {}): Field {
  const input = h('input', { type: 'text', autocomplete: 'off', ...options.attributes });
  input.value = options.value ?? '';
  return field(label, input, options);
}

export interface Choice {
  value: string;
  label: string;
}

export function selectField(label: string, choices: readonly Choice[], options: TsdfOptions = {}): Field {
  const input = h('select', options.attributes,
    ...choices.map((choice) => h('option', { value: choice.value }, choice.label)));
  if (options.value !== undefined) {
    input.value = options.value;
  }
  return field(label, input, options);
}

function field(label: string, input: HTMLInputElement | HTMLSelectElement, options: TsdfOptions): Field {
  input.id = newId('field');
  const hintId = `${input.id}-hint`;
  const errorId = `${input.id}-error`;
  // There from the beginning, so that a screen reader notices what comes into it.
  const error = h('p', { id: errorId, class: 'field-error', role: 'alert' });
  const describe = (...ids: string[]): void => {
    const all = [...(options.hint ? [hintId] : []), ...ids];
    if (all.length > 0) {
      input.setAttribute('aria-describedby', all.join(' '));
    } else {
      input.removeAttribute('aria-describedby');
    }
  };
  describe();
  const clear = (): void => {
    error.textContent = '';
    input.removeAttribute('aria-invalid');
    describe();
  };
  const element = h('div', { class: 'field' },
    h('label', { for: input.id }, label),
    options.hint ? h('p', { id: hintId, class: 'hint' }, options.hint) : null,
    error, // above, so that no keyboard on the screen hides it
    input);
  return {
    element,
    input,
    value: () => input.value.trim(),
    fail: (why) => {
      showWhy(error, why);
      input.setAttribute('aria-invalid', 'true');
      describe(errorId);
      input.focus();
    },
    clear,
  };
}

export interface CheckField {
  element: HTMLElement;
  input: HTMLInputElement;
}

export function checkField(label: string, checked: boolean, changed: (checked: boolean) => void): CheckField {
  const input = h('input', { type: 'checkbox', id: newId('check') });
  input.checked = checked;
  input.addEventListener('change', () => changed(input.checked));
  return { input, element: h('div', { class: 'check' }, input, h('label', { for: input.id }, label)) };
}

// A group of radio buttons.
export function radioField(
  legend: string, choices: readonly Choice[], chosen: string | null, changed: (value: string) => void,
): HTMLFieldSetElement {
  const name = newId('choice');
  const group = h('fieldset', { class: 'radios' }, h('legend', {}, legend));
  for (const choice of choices) {
    const input = h('input', { type: 'radio', name, id: newId('radio'), value: choice.value });
    input.checked = choice.value === chosen;
    input.addEventListener('change', () => changed(choice.value));
    group.append(h('div', { class: 'check' }, input, h('label', { for: input.id }, choice.label)));
  }
  return group;
}
