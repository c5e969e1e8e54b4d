// Whether questions are heard: a computer that neither answers one nor says anything else for so long is as good as gone,
// also where no frame is under way. Pure.

export const kAnsweredWithinMs = 2500;

export class AnswerWatch {
  private asked: number | null = null; // the newest question, until it is answered
  private silentSince = 0;

  ask(id: number, now: number): void {
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

  silent(now: number): boolean {
    return this.asked !== null && now - this.silentSince >= kAnsweredWithinMs;
  }

  reset(): void {
    this.asked = null;
  }
}
