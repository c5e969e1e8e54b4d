// The last metre: pulses whose rate tells how near the goal is and whether the camera points at it, as sensors for parking do.
// Pure but for what is handed in.
import type { Aim } from '../shared/protocol';

export interface Pulse {
  everyMs: number;
  pan: number; // -1: left, 1: right
  from: number; // Hz
  to: number; // glides there: up to the right, down to the left
  buzzMs: number; // of vibration
}

export const kFastestMs = 120; // faster ones run into one
export const kSlowestMs = 1000; // slower ones do not hold together, and a value holds no longer
const kMsPerMetre = 500;
const kHalfRateDegrees = 45; // so far beside it they are half as fast
const kAheadDegrees = 10; // a place's heading is no exacter
const kAheadHz = 880;
const kOctaveDegrees = 90;

export function pulseOf({ bearing_degrees, distance_m }: Pick<Aim, 'bearing_degrees' | 'distance_m'>): Pulse {
  const beside = Math.abs(bearing_degrees);
  const everyMs = kMsPerMetre * distance_m * (1 + beside / kHalfRateDegrees);
  const right = beside <= kAheadDegrees ? 0 : -Math.max(-kOctaveDegrees, Math.min(kOctaveDegrees, bearing_degrees)) / kOctaveDegrees;
  const lower = kAheadHz * 2 ** -Math.abs(right); // an octave at most: what is ahead is highest
  return {
    everyMs: Math.min(kSlowestMs, Math.max(kFastestMs, everyMs)),
    pan: Math.sin(right * Math.PI / 2),
    from: lower,
    to: lower * 2 ** (right / 2),
    buzzMs: 30,
  };
}

export interface AimParts {
  now: () => number;
  after: (ms: number, run: () => void) => void;
  isSilent: () => boolean; // nobody speaks or is listened to
  play: (pulse: Pulse) => void;
}

export class AimPlayer {
  private aim: Aim | null = null;
  private playedAt = -Infinity;
  private steps = 0; // counts them: an earlier one's timer is of no interest any more

  constructor(private readonly parts: AimParts) {}

  hear(aim: Aim): void {
    this.aim = aim;
    this.step();
  }

  // Until the next value.
  stop(): void {
    this.aim = null;
  }

  private step(): void {
    this.steps += 1;
    const mine = this.steps;
    const now = this.parts.now();
    if (this.aim === null || now > this.aim.valid_until_t) {
      return;
    }
    const pulse = pulseOf(this.aim);
    if (now >= this.playedAt + pulse.everyMs) {
      this.playedAt = now;
      if (this.parts.isSilent()) {
        this.parts.play(pulse);
      }
    }
    this.parts.after(this.playedAt + pulse.everyMs - now, () => {
      if (mine === this.steps) {
        this.step();
      }
    });
  }
}
