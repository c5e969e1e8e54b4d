// Short sounds before the words, told apart by contour and length, not by pitch alone.
import type { Sound } from '../shared/protocol';
import type { Pulse } from './aim';
import type { QueuedPrompt } from './prompt_queue';

export interface Note {
  at: number; // seconds after the beginning
  for: number;
  from: number; // Hz
  to: number; // glides there
  wave: OscillatorType;
}

const kPulseS = 0.06;

const note = (at: number, length: number, from: number, to = from, wave: OscillatorType = 'sine'): Note => ({
  at, for: length, from, to, wave,
});

const kNotes: Record<Sound, readonly Note[]> = {
  none: [],
  answer: [note(0, 0.14, 784)], // one clear note
  unsure: [note(0, 0.12, 587), note(0.16, 0.2, 587, 660, 'triangle')], // asks back
  lost: [note(0, 0.45, 523, 196, 'triangle')], // slides down
  back: [note(0, 0.09, 523), note(0.1, 0.09, 659), note(0.2, 0.14, 784)], // climbs
  alert: [note(0, 0.1, 1175, 1175, 'square'), note(0.14, 0.1, 1175, 1175, 'square'), note(0.28, 0.1, 1175, 1175, 'square')],
};

// Milliseconds on and off; the same contours for the hand.
const kVibrations: Record<Sound, readonly number[]> = {
  none: [],
  answer: [40],
  unsure: [40, 80, 40],
  lost: [300],
  back: [40, 60, 40, 60, 120],
  alert: [120, 60, 120, 60, 120],
};

// Of who is led, to be told apart by the hand alone; also in a pocket.
const kGuideVibrations: readonly [RegExp, readonly number[]][] = [
  [/^guide\.(turn|turn_hour|little|try)_left$/, [240, 100, 60]],
  [/^guide\.(turn|turn_hour|little|try)_right$/, [60, 100, 240]],
  [/^(guide\.(stop|off|lost)|device\.connection_lost_led$)/, [400, 100, 400]],
  [/^guide\.there_(ahead|behind|left|right|here|room)$/, [60, 60, 60, 60, 60, 60, 400]],
];

export function notesOf(sound: Sound): readonly Note[] {
  return kNotes[sound];
}

export function vibrationOf({ sound, message = '' }: Pick<QueuedPrompt, 'sound' | 'message'>): readonly number[] {
  return kGuideVibrations.find(([pattern]) => pattern.test(message))?.[1] ?? kVibrations[sound];
}

export function lengthMs(sound: Sound): number {
  return Math.max(0, ...kNotes[sound].map((one) => 1000 * (one.at + one.for)));
}

// Plays them. Phones let a page sound only after a tap: `prime` belongs into its handler.
export class Earcons {
  private context: AudioContext | null = null;

  prime(): void {
    this.context ??= 'AudioContext' in window ? new AudioContext() : null;
    void this.context?.resume();
  }

  // Gives how long it lasts; words wait for its end.
  play(sound: Sound): number {
    const context = this.context;
    if (!context || context.state !== 'running') {
      return 0;
    }
    for (const one of kNotes[sound]) {
      this.playNote(context, one);
    }
    return lengthMs(sound);
  }

  // One of the last metre's pulses.
  pulse({ from, to, pan }: Pick<Pulse, 'from' | 'to' | 'pan'>): void {
    if (this.context?.state === 'running') {
      this.playNote(this.context, note(0, kPulseS, from, to), pan);
    }
  }

  private playNote(context: AudioContext, one: Note, pan = 0): void {
    const begin = context.currentTime + one.at;
    const end = begin + one.for;
    const oscillator = context.createOscillator();
    const gain = context.createGain();
    oscillator.type = one.wave;
    oscillator.frequency.setValueAtTime(one.from, begin);
    oscillator.frequency.linearRampToValueAtTime(one.to, end);
    const loudness = one.wave === 'square' ? 0.08 : 0.25;
    gain.gain.setValueAtTime(0, begin);
    gain.gain.linearRampToValueAtTime(loudness, begin + 0.01);
    gain.gain.setValueAtTime(loudness, end - 0.03);
    gain.gain.linearRampToValueAtTime(0, end);
    const panner = context.createStereoPanner();
    panner.pan.value = pan;
    oscillator.connect(gain).connect(panner).connect(context.destination);
    oscillator.start(begin);
    oscillator.stop(end);
  }
}

// iOS has no vibration for pages: it is an addition and never the only sign.
export function vibrate(pattern: readonly number[]): void {
  if (pattern.length > 0 && 'vibrate' in navigator) {
    navigator.vibrate([...pattern]);
  }
}
