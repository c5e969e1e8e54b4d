// A question in one's own words: typed, or said where the phone itself understands speech.
import { openDialog } from '../shared/dialog';
import { h } from '../shared/dom';
import { textField } from '../shared/forms';
import { icon } from '../shared/icons';
import { text } from '../shared/texts';
import type { HearingFailure, LocalHearing } from './local_hearing';

const kLongest = 160; // letters; the computer takes 500 bytes

// `hears`: there is a button to speak, so that the hint need not tell of other ways.
export function openWords(hears: boolean, ask: (words: string) => void): void {
  const field = textField(text('words.label'), {
    hint: text(hears ? 'words.by_phone' : 'words.by_keyboard'),
    attributes: { enterkeyhint: 'send', autocapitalize: 'sentences', maxlength: kLongest, autofocus: true },
  });
  field.input.addEventListener('input', () => field.clear());
  const form = h('form', { novalidate: true, class: 'choice-form' }, field.element,
    h('button', { type: 'submit', class: 'primary' }, text('words.ask')));
  form.addEventListener('submit', (event) => {
    event.preventDefault();
    if (field.value() === '') {
      field.fail(text('words.missing'));
      return;
    }
    dialog.close();
    ask(field.value());
  });
  const dialog = openDialog(text('words.title'), [form]);
}

export interface SpeakActions {
  ask: (words: string) => void;
  listening: () => void; // nobody is to speak meanwhile
  failed: (why: HearingFailure) => void;
}

// Listens while it is pressed in; hidden until the phone is known to understand speech by itself.
export class SpeakButton {
  readonly element = h('button', { type: 'button', class: 'tool speak', hidden: true, 'aria-pressed': 'false', onclick: () => this.press() });
  private readonly label = h('span', {}, text('words.speak'));
  private hearing: LocalHearing | null = null;

  constructor(private readonly actions: SpeakActions) {
    this.element.append(icon('speak'), this.label);
  }

  get hears(): boolean {
    return this.hearing !== null;
  }

  offer(hearing: LocalHearing | null): void {
    this.hearing = hearing;
    this.element.hidden = hearing === null;
  }

  private press(): void {
    if (this.hearing?.listens) {
      this.hearing.stop();
    } else {
      this.actions.listening();
      this.hearing?.begin(this.actions.ask, this.actions.failed, () => this.show());
    }
    this.show();
  }

  private show(): void {
    const listens = this.hearing?.listens ?? false;
    this.element.setAttribute('aria-pressed', String(listens));
    this.label.textContent = text(listens ? 'words.listening' : 'words.speak');
  }
}
