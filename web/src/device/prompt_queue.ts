// What is said next. Pure: the caller hands in the clock (milliseconds) and does the speaking. The rules are those of the
// library's queue (roomwise/guide/words/prompt_queue.h):
//
// - The most urgent first; of equals, the one that came first.
// - A newer prompt takes the place of a waiting one of the same key, and of the parts of that ("around/2"), also where it
//   is not said itself; it is as urgent as what it replaces: somebody asked.
// - Nothing begins after its valid_until_t. An answer of which nothing was begun by then is lost, and that can be told.
// - A hazard interrupts all but a hazard. It comes with every picture that shows it: the same one not again within 4 s.
//   An answer that was asked for interrupts a notice or callout, since it holds for seconds.
//   An answer or notice that was broken off is begun again afterwards, where it still holds and what broke it off is no newer
//   word on the same.
// - Callouts: 0.75 s of silence before one, whatever was said last; not what was said within a minute, by an answer either;
//   none while it is quiet.
import type { Priority, Prompt } from '../shared/protocol';

export type QueuedPrompt = Pick<
  Prompt,
  'key' | 'text' | 'language' | 'priority' | 'sound' | 'valid_until_t'
> & Partial<Pick<Prompt, 'answer_to' | 'message'>>; // a guide also speaks by itself, as urgently as it answers

export const kCalloutGapMs = 750;
export const kSameCalloutMs = 60_000;
export const kSameHazardMs = 4000;
const kUrgency: Record<Priority, number> = { hazard: 0, answer: 1, notice: 2, callout: 3 };

export type Step<P> =
  | { do: 'nothing' }
  | { do: 'begin'; prompt: P; interrupts: boolean }
  | { do: 'wait'; until: number }; // ask again then

interface Waiting<P> {
  prompt: P;
  place: number; // in the order of coming
  isAskedFor: boolean;
  wasBegun: boolean; // and broken off
}

export class PromptQueue<P extends QueuedPrompt = QueuedPrompt> {
  private waiting: Waiting<P>[] = [];
  private spoken: P | null = null;
  private quiet = false;
  private silentSince = -Infinity;
  private readonly begunAt = new Map<string, number>(); // when a key and text was begun last, as long as that matters
  private places = 0;
  private lost = false;

  push(newest: P, now: number): void {
    const prompt = { ...newest };
    let place = this.places++;
    let isAskedFor = isAnswer(prompt);
    const older = this.waiting.filter((one) => isOf(one.prompt.key, prompt.key));
    for (const one of older.filter((each) => !isLate(each.prompt, now))) {
      prompt.priority = moreUrgent(prompt.priority, one.prompt.priority);
      place = Math.min(place, one.place);
      isAskedFor ||= one.isAskedFor;
    }
    // Also where this one is not said: it is the newer word on the same.
    this.waiting = this.waiting.filter((one) => !older.includes(one));
    const isUnwanted = this.quiet && prompt.priority === 'callout';
    if (!isUnwanted && !this.wasSaidLately(prompt, now)) {
      this.waiting.push({ prompt, place, isAskedFor, wasBegun: false });
    }
  }

  // What to do at `now`. A prompt that it begins counts as being spoken until `ended`.
  step(now: number): Step<P> {
    this.dropLate(now);
    const next = this.mostUrgent(now);
    if (next) {
      const broken = this.spoken;
      this.begin(next, now);
      this.keep(broken, next.prompt);
      return { do: 'begin', prompt: next.prompt, interrupts: broken !== null };
    }
    const afterGap = this.silentSince + kCalloutGapMs;
    const isGap = !this.spoken && afterGap > now && this.mostUrgent(afterGap) !== null;
    return isGap ? { do: 'wait', until: afterGap } : { do: 'nothing' };
  }

  // The prompt that was begun is over, spoken to its end or stopped.
  ended(now: number): void {
    if (this.spoken) {
      this.spoken = null;
      this.silentSince = now;
    }
  }

  // What is spoken was broken off, and not by a hazard: it begins again later, as after one.
  putBack(now: number): void {
    const broken = this.spoken;
    this.ended(now);
    this.keep(broken, null);
  }

  // A hazard waits that may be told now.
  warns(now: number): boolean {
    return this.mostUrgent(now)?.prompt.priority === 'hazard';
  }

  get speaking(): P | null {
    return this.spoken;
  }

  // Something else is asked, or silence: what was asked before is not gone on with.
  withdrawAnswers(): void {
    this.waiting = this.waiting.filter(({ prompt }) => prompt.priority !== 'answer');
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
      this.waiting = this.waiting.filter(({ prompt }) => prompt.priority !== 'callout');
    }
  }

  private begin(next: Waiting<P>, now: number): void {
    this.ended(now); // what is interrupted
    this.waiting.splice(this.waiting.indexOf(next), 1);
    this.spoken = next.prompt;
    for (const [name, at] of this.begunAt) {
      if (now - at > kSameCalloutMs) {
        this.begunAt.delete(name);
      }
    }
    this.begunAt.set(nameOf(next.prompt), now);
  }

  // What was broken off comes before its own parts, which came later, unless there is a newer word on the same by now.
  // Callouts are not worth a second beginning.
  private keep(broken: P | null, by: P | null): void {
    if (!broken || broken.priority === 'callout') {
      return;
    }
    const isSuperseded = this.waiting.some(({ prompt }) => prompt.key === broken.key) || (by !== null && isOf(broken.key, by.key));
    if (isSuperseded) {
      return;
    }
    const parts = this.waiting.filter(({ prompt }) => wholeOf(prompt) === wholeOf(broken));
    const place = Math.min(this.places++, ...parts.map((part) => part.place));
    this.waiting.unshift({ prompt: broken, place, isAskedFor: false, wasBegun: true });
  }

  private dropLate(now: number): void {
    const late = this.waiting.filter(({ prompt }) => isLate(prompt, now));
    this.lost ||= late.some(({ prompt, isAskedFor, wasBegun }) => prompt.priority === 'answer' && isAskedFor && !wasBegun);
    this.waiting = this.waiting.filter((one) => !late.includes(one));
  }

  private mostUrgent(now: number): Waiting<P> | null {
    const may = this.waiting.filter((one) => this.mayBegin(one, now));
    may.sort((a, b) => kUrgency[a.prompt.priority] - kUrgency[b.prompt.priority] || a.place - b.place);
    return may[0] ?? null;
  }

  private mayBegin(one: Waiting<P>, now: number): boolean {
    const { prompt } = one;
    if (isLate(prompt, now) || this.wasSaidLately(prompt, now)) {
      return false;
    }
    if (this.spoken) {
      return interrupts(one, this.spoken.priority);
    }
    return prompt.priority !== 'callout' || now >= this.silentSince + kCalloutGapMs;
  }

  private wasSaidLately(prompt: P, now: number): boolean {
    return now < (this.begunAt.get(nameOf(prompt)) ?? -Infinity) + againAfterMs(prompt);
  }
}

function interrupts({ prompt, isAskedFor }: Waiting<QueuedPrompt>, spoken: Priority): boolean {
  if (prompt.priority === 'hazard') {
    return spoken !== 'hazard';
  }
  return prompt.priority === 'answer' && isAskedFor && kUrgency[spoken] > kUrgency.answer;
}

function isAnswer(prompt: QueuedPrompt): boolean {
  return typeof prompt.answer_to === 'number';
}

function againAfterMs({ priority }: QueuedPrompt): number {
  return priority === 'callout' ? kSameCalloutMs : priority === 'hazard' ? kSameHazardMs : 0;
}

function isLate(prompt: QueuedPrompt, now: number): boolean {
  return now > prompt.valid_until_t;
}

function moreUrgent(one: Priority, other: Priority): Priority {
  return kUrgency[one] <= kUrgency[other] ? one : other;
}

function nameOf(prompt: QueuedPrompt): string {
  return `${prompt.key}\n${prompt.text}`;
}

// "around/2" is a part of "around".
function isOf(key: string, whole: string): boolean {
  return key === whole || key.startsWith(`${whole}/`);
}

function wholeOf({ key }: QueuedPrompt): string {
  return key.split('/')[0] ?? key;
}
