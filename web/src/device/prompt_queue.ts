// What is said next. Pure: the caller hands in the clock (milliseconds) and does the speaking.
//
// - The most urgent first; of equals, the one that came first.
// - A newer prompt takes the place of a waiting one of the same key, and of the parts of that ("around/2").
// - Nothing begins after its valid_until_t.
// - A hazard interrupts all but a hazard.
// - Callouts: 0.75 s between two of them, the same one not again within a minute, none while it is quiet.
import type { Priority, Prompt } from '../shared/protocol';

export type QueuedPrompt = Pick<
  Prompt,
  'key' | 'text' | 'language' | 'priority' | 'sound' | 'valid_until_t'
>;

export const kCalloutGapMs = 750;
export const kSameCalloutMs = 60_000;
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
  private readonly calloutBegun = new Map<string, number>();

  // False where it will never be said.
  push(prompt: P, now: number): boolean {
    if (prompt.valid_until_t < now || (this.isCallout(prompt) && this.isUnwanted(prompt, now))) {
      return false;
    }
    this.waiting = this.waiting.filter((other) => !other.key.startsWith(`${prompt.key}/`));
    const same = this.waiting.findIndex((other) => other.key === prompt.key);
    if (same >= 0) {
      this.waiting[same] = prompt;
    } else {
      this.waiting.push(prompt);
    }
    return true;
  }

  // What to do at `now`. A prompt that it begins counts as being spoken until `ended`.
  step(now: number): Step<P> {
    this.waiting = this.waiting.filter((prompt) => prompt.valid_until_t >= now);
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
    this.begin(next, now);
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
    if (this.isCallout(prompt)) {
      this.calloutBegun.set(calloutName(prompt), now);
    }
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

  private isUnwanted(callout: QueuedPrompt, now: number): boolean {
    const begun = this.calloutBegun.get(calloutName(callout));
    return this.quiet || (begun !== undefined && now - begun < kSameCalloutMs);
  }
}

function calloutName(prompt: QueuedPrompt): string {
  return `${prompt.key}\n${prompt.text}`;
}
