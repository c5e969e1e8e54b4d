// Who is led is led on after the connection was lost: the computer forgets with it by what they were. Pure.
import type { Prompt, Question } from '../shared/protocol';

// So long a picture is waited for that tells where they are: without one they would be told to turn.
export const kPlacedMs = 4000;

// After these the guide has nothing more to do, but for how high to reach.
const kEnds = ['guide.there', 'guide.ended', 'guide.near_end', 'guide.not_running'];

// Of a question in words: what it asked for was to be led. "How far" is answered by the guide, too.
const kBegins = ['guide.begin', 'route.'];

const startsWithAny = (message: string, starts: string[]): boolean => starts.some((start) => message.startsWith(start));

export class LedAgain {
  private asked: { id: number; question: Question } | null = null; // the newest that may lead
  private ledBy: Question | null = null;
  private isLost = false;
  private seesPlacesSince: number | null = null; // the computer
  private isPaused = false;

  get isLed(): boolean {
    return this.ledBy !== null;
  }

  ask(id: number, question: Question): void {
    if (question.question === 'in_words') {
      this.asked = { id, question };
    } else if (question.question === 'take_me_to' || question.question === 'take_me_back') {
      this.asked = { id, question };
      this.ledBy = question; // until the answer says otherwise
      this.isLost = false;
      this.isPaused = false;
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
    this.isPaused = question.wish === 'pause' || (this.isPaused && question.wish !== 'resume');
    return question.wish === 'resume' ? this.take() : null;
  }

  heard(prompt: Pick<Prompt, 'key' | 'message' | 'answer_to'>): void {
    if (this.asked !== null && prompt.answer_to === this.asked.id) {
      this.hearAnswer(this.asked.question, prompt);
      this.asked = null;
    }
    // A computer that came back says so of whom it has forgotten: they are still to be led on.
    const hasForgotten = this.isLost && prompt.message === 'guide.not_running';
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
    this.isLost = true;
    this.asked = null; // no answer will come
    this.seesPlacesSince = null;
    return this.ledBy !== null;
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
      this.ledBy = question;
      this.isLost = false;
      this.isPaused = false;
    } else if (!isWords) {
      this.end();
    }
  }

  private end(): void {
    this.ledBy = null;
    this.isPaused = false;
  }

  // Not while words wait for their answer: they may ask for something else.
  private take(): Question | null {
    if (!this.isLost || this.isPaused || this.ledBy === null || this.seesPlacesSince === null || this.asked !== null) {
      return null;
    }
    this.isLost = false;
    return this.ledBy;
  }
}
