// A question in one's own words: typed, or said where the phone itself understands speech.
import { h } from '../shared/dom';
import { textField } from '../shared/forms';
import { icon } from '../shared/icons';
import { text } from '../shared/texts';
import type { HearingFailure, LocalHearing } from './local_hearing';

const kLongest = 160; // letters; the computer takes 500 bytes

export interface WordsActions {
  ask: (words: string) => void;
  listening: () => void; // nobody is to speak meanwhile
  failed: (why: HearingFailure) => void;
}

export class WordsForm {
  readonly element: HTMLFormElement;
  private readonly field;
  private readonly hint = h('p', { class: 'hint' }, text('words.by_keyboard'));
  private readonly buttons: HTMLElement;

  constructor(private readonly actions: WordsActions) {
    this.field = textField(text('words.label'), {
      attributes: { enterkeyhint: 'send', autocapitalize: 'sentences', maxlength: kLongest },
    });
    this.buttons = h('div', { class: 'words-buttons' }, h('button', { type: 'submit' }, text('words.ask')));
    this.element = h('form', { class: 'words', novalidate: true }, this.field.element, this.buttons, this.hint);
    this.field.input.addEventListener('input', () => this.field.clear());
    this.element.addEventListener('submit', (event) => {
      event.preventDefault();
      this.send(this.field.value());
    });
  }

  // The phone can hear by itself.
  offer(hearing: LocalHearing): void {
    const label = h('span', {}, text('words.speak'));
    const button = h('button', { type: 'button', 'aria-pressed': 'false' }, icon('speak'), label);
    const show = (): void => {
      button.setAttribute('aria-pressed', String(hearing.listens));
      label.textContent = text(hearing.listens ? 'words.listening' : 'words.speak');
    };
    button.addEventListener('click', () => {
      if (hearing.listens) {
        hearing.stop();
      } else {
        this.actions.listening();
        hearing.begin((words) => this.send(words), this.actions.failed, show);
      }
      show();
    });
    this.buttons.append(button);
    this.hint.textContent = text('words.by_phone');
  }

  private send(words: string): void {
    if (words === '') {
      this.field.fail(text('words.missing'));
      return;
    }
    this.field.clear();
    (this.field.input as HTMLInputElement).value = '';
    this.actions.ask(words);
  }
}
