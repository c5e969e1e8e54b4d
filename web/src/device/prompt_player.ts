// Carries out what the queue decides: the sound first, then the words, by the speaker that was chosen.
import { PromptQueue, type QueuedPrompt } from './prompt_queue';
import type { Speaker } from './speaker';

export interface PlayerParts {
  now: () => number;
  speaker: (prompt: QueuedPrompt) => Speaker;
  sound: (prompt: QueuedPrompt) => number; // plays it; gives its length in milliseconds
  after: (ms: number, run: () => void) => void;
  lostAnswer: (now: number) => QueuedPrompt; // said instead of an answer that came too late
}

export class PromptPlayer {
  private readonly queue = new PromptQueue();
  private begun = 0; // counts prompts: what belongs to an earlier one is of no interest any more
  private speaker: Speaker | null = null; // who speaks now
  private isOver = false; // the last words were given
  private hazardComes: (() => void) | null = null; // while nothing is said; told when that must end

  constructor(private readonly parts: PlayerParts) {}

  push(prompt: QueuedPrompt): void {
    this.queue.push(prompt, this.parts.now());
    this.pump();
  }

  // The page ends with these words; nothing is said after them.
  sayLast(prompt: QueuedPrompt, over: () => void): void {
    this.isOver = true;
    this.speaker?.stop();
    this.begin(prompt, over);
  }

  // The person asks something else: answers are not gone on with, neither the one that is being said.
  withdrawAnswers(): void {
    this.queue.withdrawAnswers();
    if (this.queue.speaking?.priority === 'answer') {
      this.breakOff();
    }
  }

  // Who wants silence gets it at once, from all but a hazard.
  setQuiet(on: boolean): void {
    this.queue.setQuiet(on);
    if (on) {
      this.queue.withdrawAnswers();
      if (this.queue.speaking && this.queue.speaking.priority !== 'hazard') {
        this.breakOff();
      }
    }
  }

  // Nobody speaks, nor is listened to.
  get isSilent(): boolean {
    return this.queue.speaking === null && this.hazardComes === null;
  }

  // Nothing is said from now on, so that a microphone hears the person alone; what waits comes after `release`. A hazard
  // ends that by itself: `hazardComes` is called first. False where one is being said: then nothing is held.
  hold(hazardComes: () => void): boolean {
    if (this.queue.speaking?.priority === 'hazard') {
      return false;
    }
    this.hazardComes = hazardComes;
    if (this.queue.speaking) {
      this.begun += 1;
      this.speaker?.stop();
      this.queue.putBack(this.parts.now());
    }
    return true;
  }

  release(): void {
    if (this.hazardComes) {
      this.hazardComes = null;
      this.pump();
    }
  }

  private breakOff(): void {
    this.begun += 1;
    this.speaker?.stop();
    this.queue.ended(this.parts.now());
    this.pump();
  }

  private pump(): void {
    if (this.isOver) {
      return;
    }
    const now = this.parts.now();
    const { hazardComes } = this;
    if (hazardComes) {
      if (!this.queue.warns(now)) {
        return;
      }
      this.hazardComes = null;
      hazardComes();
    }
    if (this.queue.takeLost(now)) {
      this.queue.push(this.parts.lostAnswer(now), now);
    }
    const step = this.queue.step(now);
    if (step.do === 'wait') {
      this.parts.after(step.until - now, () => this.pump());
    }
    if (step.do === 'begin') {
      if (step.interrupts) {
        this.speaker?.stop();
      }
      this.begin(step.prompt, () => {
        this.queue.ended(this.parts.now());
        this.pump();
      });
    }
  }

  private begin(prompt: QueuedPrompt, then: () => void): void {
    this.begun += 1;
    const mine = this.begun;
    const speaker = this.parts.speaker(prompt);
    this.speaker = speaker;
    const over = (): void => {
      if (mine === this.begun) {
        then();
      }
    };
    this.parts.after(this.parts.sound(prompt), () => {
      if (mine === this.begun) {
        speaker.say(prompt, over);
      }
    });
  }
}
