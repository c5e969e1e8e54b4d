// Who is led is led on after the connection was lost: the computer forgets with it by what they were. Pure.
import type { Prompt, Question } from '../shared/protocol';

// So long a picture is waited for that tells where they are: without one they would be told to turn.
export const kPlacedMs = 4000;

// After these the guide has nothing more to do, but for how high to reach.
const kEnds = ['guide.there', 'guide.ended', 'guide.near_end', 'guide.not_running', 'where.unknown', 'where.no_way_out', 'spot.no_way_back'];

export function endsGuidance(prompt: Pick<Prompt, 'message'>): boolean {
  return kEnds.some((end) => prompt.message.startsWith(end));
}

export class LedAgain {
  private asked: { id: number; question: Question } | null = null; // the newest that may lead
  private ledBy: Question | null = null;
  private isLost = false;
  private seesPlacesSince: number | null = null; // the computer
  private isPaused = false;

  ask(id: number, question: Question): void {
    if (question.question === 'take_me_to' || question.question === 'take_me_back' || question.question === 'in_words') {
      this.asked = { id, question };
      this.isPaused = question.question === 'in_words' && this.isPaused;
    }
  }

  // A wish of who is led, also while there is no connection. Returns by what to lead them on now.
  wish(question: Question): Question | null {
    if (question.question !== 'guide') {
      return null;
    }
    if (question.wish === 'end') {
      this.ledBy = null;
    }
    this.isPaused = question.wish === 'pause' || (this.isPaused && question.wish !== 'resume');
    return question.wish === 'resume' ? this.take() : null;
  }

  heard(prompt: Pick<Prompt, 'key' | 'message' | 'answer_to'>): void {
    if (this.asked !== null && prompt.answer_to === this.asked.id && prompt.key === 'guide') {
      this.ledBy = this.asked.question;
      this.isLost = false;
    }
    if (endsGuidance(prompt)) {
      this.ledBy = null;
    }
  }

  // True where somebody is led, and must stop.
  lost(): boolean {
    this.isLost = true;
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

  private take(): Question | null {
    if (!this.isLost || this.isPaused || this.ledBy === null || this.seesPlacesSince === null) {
      return null;
    }
    this.isLost = false;
    return this.ledBy;
  }
}
