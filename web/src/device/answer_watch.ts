// Whether questions are heard: a computer that neither answers one nor says anything else for so long is as good as gone,
// also where no frame is under way. One that is heard of and takes long is waited for. Pure.
import type { Prompt } from '../shared/protocol';
import { earlier } from '../shared/spoken';

export const kAnsweredWithinMs = 2500;
export const kLongMs = 3000; // then who asks is told to wait
export const kWorthHearingMs = 15_000; // from the question on
const kLateHoldsMs = 10_000;
const kToWalkBy = /^(guide|route|ahead|around|beside)\.|^where\.(close|direction)/; // messages: true of one place and heading

export class AnswerWatch {
  private asked: number | null = null; // the newest question, until it is answered
  private askedAt = 0;
  private isToldToWait = false;
  private silentSince = 0;

  ask(id: number, now: number): void {
    this.askedAt = now;
    this.isToldToWait = false;
    if (this.asked === null) {
      this.silentSince = now; // who asks again and again must not wait longer
    }
    this.asked = id;
  }

  // Any message of the computer; `answerTo`: the question that it answers.
  heard(answerTo: number | null, now: number): void {
    this.silentSince = now;
    if (answerTo === this.asked) {
      this.asked = null;
    }
  }

  get waits(): boolean {
    return this.asked !== null;
  }

  silent(now: number): boolean {
    return this.asked !== null && now - this.silentSince >= kAnsweredWithinMs;
  }

  // True once a question.
  takesLong(now: number): boolean {
    const isLong = this.asked !== null && !this.isToldToWait && now - this.askedAt >= kLongMs;
    this.isToldToWait ||= isLong;
    return isLong;
  }

  // An answer that comes when it need not be true any more is told as what was so. But nobody is to walk by such words.
  inTime(prompt: Prompt, now: number): Prompt {
    const isLate = prompt.priority === 'answer' && typeof prompt.answer_to === 'number' && now > prompt.valid_until_t;
    if (!isLate || now - this.askedAt > kWorthHearingMs || kToWalkBy.test(prompt.message)) {
      return prompt;
    }
    const isPart = prompt.key.includes('/'); // of an answer that began with the word
    const text = isPart ? prompt.text : earlier(prompt.language, prompt.text);
    return { ...prompt, text, valid_until_t: now + kLateHoldsMs };
  }

  reset(): void {
    this.asked = null;
  }
}
