// Who is led is led on after the connection was lost: the computer forgets with it by what they were. Pure.
import type { Prompt, Question } from '../shared/protocol';

// So long a picture is waited for that tells where they are: without one they would be told to turn.
export const kPlacedMs = 4000;

// After these the guide has nothing more to do, but for how high to reach.
const kEnds = ['guide.there', 'guide.ended', 'guide.near_end', 'guide.not_running'];

// Of a question in words: what it asked for was to be led. "How far" is answered by the guide, too.
const kBegins = ['guide.begin', 'route.'];

const startsWithAny = (message: string, starts: string[]): boolean => starts.some((start) => message.startsWith(start));

interface Led {
  by: Question | null;
  isLost: boolean;
  isPaused: boolean;
}

const kNotLed: Led = { by: null, isLost: false, isPaused: false };

export class LedAgain {
  private asked: { id: number; question: Question } | null = null; // the newest that may lead
  private led = kNotLed;
  private before = kNotLed; // holds again where the goal that was asked for last is not known
  private isUnanswered = false; // when the connection was lost nobody had said whether the goal is known
  private seesPlacesSince: number | null = null; // the computer

  get isLed(): boolean {
    return this.led.by !== null;
  }

  ask(id: number, question: Question): void {
    const asksToBeLed = question.question === 'take_me_to' || question.question === 'take_me_back';
    if (asksToBeLed) {
      const waits = this.isUnanswered || (this.asked !== null && this.asked.question === this.led.by);
      this.isUnanswered = false;
      const isAskedAnew = question === this.led.by; // of a computer that led nobody before
      this.before = waits ? this.before : isAskedAnew ? kNotLed : this.led;
      this.led = { ...kNotLed, by: question }; // until the answer says otherwise
    }
    if (asksToBeLed || question.question === 'in_words') {
      this.asked = { id, question };
    }
  }

  // A wish of who is led, also while there is no connection. Returns by what to lead them on now.
  wish(question: Question): Question | null {
    if (question.question !== 'guide') {
      return null;
    }
    if (question.wish === 'end') {
      this.end();
    }
    const isPaused = question.wish === 'pause' || (this.led.isPaused && question.wish !== 'resume');
    this.led = { ...this.led, isPaused };
    return question.wish === 'resume' ? this.take() : null;
  }

  heard(prompt: Pick<Prompt, 'key' | 'message' | 'answer_to'>): void {
    if (this.asked !== null && prompt.answer_to === this.asked.id) {
      this.hearAnswer(this.asked.question, prompt);
      this.asked = null;
    }
    // A computer that came back says so of whom it has forgotten: they are still to be led on.
    const hasForgotten = this.led.isLost && prompt.message === 'guide.not_running';
    if (startsWithAny(prompt.message, kEnds) && !hasForgotten) {
      this.end();
    }
  }

  // A question that the computer could not answer.
  refused(id: number): void {
    if (this.asked?.id === id) {
      this.hearAnswer(this.asked.question, { key: '', message: '' });
      this.asked = null;
    }
  }

  // True where somebody is led, and must stop.
  lost(): boolean {
    this.isUnanswered ||= this.asked !== null && this.asked.question === this.led.by;
    this.led = { ...this.led, isLost: true };
    this.before = { ...this.before, isLost: true };
    this.asked = null; // no answer will come
    this.seesPlacesSince = null;
    return this.isLed;
  }

  sees(places: boolean, now: number): void {
    this.seesPlacesSince = places ? (this.seesPlacesSince ?? now) : null;
  }

  // A picture was looked at: by what to lead them on, if anything.
  seen(isPlaced: boolean, now: number): Question | null {
    const hasWaited = this.seesPlacesSince !== null && now - this.seesPlacesSince > kPlacedMs;
    return isPlaced || hasWaited ? this.take() : null;
  }

  private hearAnswer(question: Question, { key, message }: Pick<Prompt, 'key' | 'message'>): void {
    const isWords = question.question === 'in_words';
    if (key === 'guide' && (!isWords || startsWithAny(message, kBegins))) {
      this.led = { ...kNotLed, by: question };
      this.isUnanswered = false;
    } else if (!isWords && this.led.by === question) {
      this.led = this.before;
    }
  }

  private end(): void {
    this.led = { ...kNotLed, isLost: this.led.isLost };
    this.before = kNotLed;
    this.isUnanswered = false;
  }

  // Not while words wait for their answer: they may ask for something else.
  private take(): Question | null {
    const { by, isLost, isPaused } = this.led;
    if (!isLost || isPaused || by === null || this.seesPlacesSince === null || this.asked !== null) {
      return null;
    }
    this.led = { ...this.led, isLost: false };
    return by;
  }
}
