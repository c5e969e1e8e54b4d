// What is said next. Pure: the caller hands in the clock (milliseconds) and does the speaking.
//
// - The most urgent first; of equals, the one that came first.
// - A newer prompt takes the place of a waiting one of the same key, and of the parts of that ("around/2"); it is as
//   urgent as what it replaces: somebody asked.
// - Nothing begins after its valid_until_t. An answer of which nothing was begun by then is lost, and that can be told.
// - A hazard interrupts all but a hazard. It comes with every picture that shows it: the same one not again within 4 s.
//   An answer or notice that it broke off is begun again afterwards, where it still holds.
// - Callouts: 0.75 s between two of them, the same one not again within a minute, none while it is quiet.
import type { Priority, Prompt } from '../shared/protocol';

export type QueuedPrompt = Pick<
  Prompt,
  'key' | 'text' | 'language' | 'priority' | 'sound' | 'valid_until_t'
>;

export const kCalloutGapMs = 750;
export const kSameCalloutMs = 60_000;
export const kSameHazardMs = 4000;
const kUrgency: Record<Priority, number> = { hazard: 0, answer: 1, notice: 2, callout: 3 };

export type Step<P> =
  | { do: 'nothing' }
  | { do: 'begin'; prompt: P; interrupts: boolean }
  | { do: 'wait'; until: number }; // ask again then

export class PromptQueue<P extends QueuedPrompt = QueuedPrompt> {
  private waiting: P[] = [];
  private spoken: P | null = null;
  private quiet = false;
  private lastCalloutEnd = -Infinity;
  private readonly begunAt = new Map<string, number>(); // of callouts and hazards
  private answering: string | null = null; // the answer that was begun last, as a whole
  private lost = false;

  // False where it will never be said.
  push(newest: P, now: number): boolean {
    const same = this.waiting.findIndex((other) => other.key === newest.key);
    const prompt = { ...newest, priority: moreUrgent(newest.priority, this.waiting[same]?.priority) };
    if (prompt.valid_until_t < now) {
      this.lose(prompt);
      return false;
    }
    if (this.isUnwanted(prompt, now)) {
      return false;
    }
    if (same >= 0) {
      this.waiting[same] = prompt;
    } else {
      this.waiting.push(prompt);
    }
    this.waiting = this.waiting.filter((other) => !other.key.startsWith(`${prompt.key}/`));
    return true;
  }

  // What to do at `now`. A prompt that it begins counts as being spoken until `ended`.
  step(now: number): Step<P> {
    this.dropLate(now);
    const next = this.mostUrgent();
    if (!next) {
      return { do: 'nothing' };
    }
    const interrupts = this.spoken !== null;
    if (interrupts && !(next.priority === 'hazard' && this.spoken?.priority !== 'hazard')) {
      return { do: 'nothing' };
    }
    const earliest = this.lastCalloutEnd + kCalloutGapMs;
    if (this.isCallout(next) && now < earliest) {
      return { do: 'wait', until: earliest };
    }
    const broken = this.spoken;
    this.begin(next, now);
    this.keep(broken);
    return { do: 'begin', prompt: next, interrupts };
  }

  // The prompt that was begun is over, spoken to its end or stopped.
  ended(now: number): void {
    if (this.spoken && this.isCallout(this.spoken)) {
      this.lastCalloutEnd = now;
    }
    this.spoken = null;
  }

  get speaking(): P | null {
    return this.spoken;
  }

  // Something else is asked, or silence: what was asked before is not gone on with.
  withdrawAnswers(): void {
    this.waiting = this.waiting.filter((prompt) => prompt.priority !== 'answer');
    this.answering = null;
  }

  // Whether an answer ran out before it could be begun; told once.
  takeLost(now: number): boolean {
    this.dropLate(now);
    const lost = this.lost;
    this.lost = false;
    return lost;
  }

  // Quiet drops the callouts that wait, too.
  setQuiet(on: boolean): void {
    this.quiet = on;
    if (on) {
      this.waiting = this.waiting.filter((prompt) => !this.isCallout(prompt));
    }
  }

  private begin(prompt: P, now: number): void {
    this.ended(now); // what is interrupted
    this.waiting.splice(this.waiting.indexOf(prompt), 1);
    this.spoken = prompt;
    if (againAfterMs(prompt) > 0) {
      this.begunAt.set(nameOf(prompt), now);
    }
    if (prompt.priority === 'answer') {
      this.answering = wholeOf(prompt);
    }
  }

  // What was broken off comes before all that waits beside it, unless there is a newer word on the same by now. Callouts
  // are not worth a second beginning.
  private keep(broken: P | null): void {
    const isSuperseded = this.waiting.some((prompt) => prompt.key === broken?.key);
    if (broken && !this.isCallout(broken) && !isSuperseded) {
      this.waiting.unshift(broken);
    }
  }

  private dropLate(now: number): void {
    this.waiting.filter((prompt) => prompt.valid_until_t < now).forEach((prompt) => this.lose(prompt));
    this.waiting = this.waiting.filter((prompt) => prompt.valid_until_t >= now);
  }

  // The rest of an answer that was begun is no loss to speak of.
  private lose(prompt: P): void {
    this.lost ||= prompt.priority === 'answer' && wholeOf(prompt) !== this.answering;
  }

  private mostUrgent(): P | null {
    let best: P | null = null;
    for (const prompt of this.waiting) {
      if (!best || kUrgency[prompt.priority] < kUrgency[best.priority]) {
        best = prompt;
      }
    }
    return best;
  }

  private isCallout(prompt: QueuedPrompt): boolean {
    return prompt.priority === 'callout';
  }

  private isUnwanted(prompt: QueuedPrompt, now: number): boolean {
    const begun = this.begunAt.get(nameOf(prompt)) ?? -Infinity;
    return (this.quiet && this.isCallout(prompt)) || now - begun < againAfterMs(prompt);
  }
}

function againAfterMs({ priority }: QueuedPrompt): number {
  return priority === 'callout' ? kSameCalloutMs : priority === 'hazard' ? kSameHazardMs : 0;
}

function moreUrgent(one: Priority, other: Priority = one): Priority {
  return kUrgency[one] <= kUrgency[other] ? one : other;
}

function nameOf(prompt: QueuedPrompt): string {
  return `${prompt.priority}\n${prompt.key}\n${prompt.text}`;
}

// "around/2" is a part of "around".
function wholeOf({ key }: QueuedPrompt): string {
  return key.split('/')[0] ?? key;
}
