// A question in one's own words: typed, or said where the phone itself understands speech.
import { openDialog } from '../shared/dialog';
import { h } from '../shared/dom';
import { textField } from '../shared/forms';
import { icon } from '../shared/icons';
import { text } from '../shared/texts';
import { Listening, type ListeningParts } from './listening';
import type { LocalHearing } from './local_hearing';

const kLongest = 160; // letters; the computer takes 500 bytes

// `speak.hears`: there is a button to speak, so that the hint need not tell of other ways. Who types is not listened to.
export function openWords(speak: SpeakButton, ask: (words: string) => void): void {
  speak.stop();
  const field = textField(text('words.label'), {
    hint: text(speak.hears ? 'words.by_phone' : 'words.by_keyboard'),
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
  const dialog = openDialog(text('words.title'), [form], () => speak.stop());
}

// Listens while it is pressed in; hidden until the phone is known to understand speech by itself.
export class SpeakButton {
  readonly element = h('button', {
    type: 'button', class: 'tool speak', hidden: true, 'aria-pressed': 'false', onclick: () => this.listening.press(),
  });
  private readonly label = h('span', {}, text('words.speak'));
  private readonly listening: Listening;

  constructor(parts: Omit<ListeningParts, 'changed'>) {
    this.listening = new Listening({ ...parts, changed: () => this.show() });
    this.element.append(icon('speak'), this.label);
    document.addEventListener('visibilitychange', () => {
      if (document.visibilityState !== 'visible') {
        this.stop();
      }
    });
  }

  get hears(): boolean {
    return this.listening.hears;
  }

  offer(hearing: LocalHearing | null): void {
    this.listening.offer(hearing);
    this.element.hidden = hearing === null;
  }

  // Without a word: something else is asked, or typed.
  stop(): void {
    this.listening.stop();
  }

  private show(): void {
    const { listens } = this.listening;
    this.element.setAttribute('aria-pressed', String(listens));
    this.label.textContent = text(listens ? 'words.listening' : 'words.speak');
  }
}
