// The phone listens to one question. Nobody speaks meanwhile, or the phone would hear itself; a hazard ends it and is told.
import type { HearingFailure, LocalHearing } from './local_hearing';

export interface ListeningParts {
  hold: (hazardComes: () => void) => boolean; // all speech; false: not now
  release: () => void;
  ask: (words: string) => void;
  failed: (why: HearingFailure) => void;
  changed: () => void;
}

export class Listening {
  private hearing: LocalHearing | null = null; // until the phone is known to understand speech by itself

  constructor(private readonly parts: ListeningParts) {}

  get hears(): boolean {
    return this.hearing !== null;
  }

  get listens(): boolean {
    return this.hearing?.listens ?? false;
  }

  offer(hearing: LocalHearing | null): void {
    this.hearing = hearing;
  }

  // Begins, or ends without a word.
  press(): void {
    if (this.listens) {
      this.stop();
    } else if (this.hearing && this.parts.hold(() => this.stop())) {
      this.hearing.begin((words) => {
        this.stop(); // one question
        this.parts.ask(words);
      }, this.parts.failed, () => this.over());
      this.parts.changed();
    }
  }

  stop(): void {
    if (this.listens) {
      this.hearing?.stop();
      this.over();
    }
  }

  private over(): void {
    this.parts.release();
    this.parts.changed();
  }
}
