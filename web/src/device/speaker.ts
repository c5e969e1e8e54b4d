// Who speaks: the phone's own voice, or the screen reader that the person uses anyway. Never both.
import type { Language } from '../shared/protocol';
import { localVoice } from './local_voices';
import type { QueuedPrompt } from './prompt_queue';
import type { SaidLog } from './said_log';

export interface Speaker {
  // `over` is called once, when the words are spoken or were stopped by another reason than `stop`.
  say(prompt: QueuedPrompt, over: () => void): void;
  stop(): void;
}

// About how long a voice needs for the words; screen readers do not tell when they are done.
export function spokenMs(words: string, rate = 1): number {
  return (400 + 65 * words.length) / rate;
}

export class OwnVoice implements Speaker {
  // Held here since some browsers forget utterances, and their events, that nobody holds.
  private utterance: SpeechSynthesisUtterance | null = null;
  private watchdog = 0;

  constructor(
    private readonly log: SaidLog,
    private readonly rate: () => number,
  ) {}

  static available(): boolean {
    return 'speechSynthesis' in window;
  }

  // iOS is silent until a page has spoken in the handler of a tap: a blank, also where no voice is known yet.
  prime(language: Language): void {
    const voice = localVoice(language);
    if (OwnVoice.available() && (voice || window.speechSynthesis.getVoices().length === 0)) {
      const blank = new SpeechSynthesisUtterance(' ');
      blank.voice = voice;
      window.speechSynthesis.speak(blank);
    }
  }

  say(prompt: QueuedPrompt, over: () => void): void {
    this.stop();
    this.log.add(prompt, 'silent');
    const voice = localVoice(prompt.language);
    if (!voice) {
      over(); // `speakerFor` asks it only where there is one
      return;
    }
    const utterance = new SpeechSynthesisUtterance(prompt.text);
    utterance.lang = prompt.language;
    utterance.rate = this.rate();
    utterance.voice = voice;
    const done = (): void => {
      if (this.utterance === utterance) {
        this.forget();
        over();
      }
    };
    utterance.onend = done;
    utterance.onerror = done;
    this.utterance = utterance;
    // Some voices never say that they are done; the queue must go on all the same.
    this.watchdog = window.setTimeout(done, 3000 + 2 * spokenMs(prompt.text, this.rate()));
    window.speechSynthesis.speak(utterance);
  }

  stop(): void {
    if (this.utterance) {
      this.forget();
      window.speechSynthesis.cancel();
    }
  }

  private forget(): void {
    this.utterance = null;
    window.clearTimeout(this.watchdog);
  }
}

export class ScreenReaderVoice implements Speaker {
  private timer = 0;

  constructor(private readonly log: SaidLog) {}

  say(prompt: QueuedPrompt, over: () => void): void {
    this.stop();
    this.log.add(prompt, 'aloud');
    this.timer = window.setTimeout(over, spokenMs(prompt.text));
  }

  stop(): void {
    window.clearTimeout(this.timer);
  }
}
