// What a person who records a walk is told meanwhile: how many pictures there are, to go slower, that the phone lost its
// way. Pure, on a clock that is handed in.
import type { FramePose } from '../../shared/protocol';

export type Advice = 'slower' | 'lost' | 'no_depth' | 'turned';

export interface WalkNews {
  advice: Advice | null;
  isBetter: boolean; // what was advised before is over
  pictures: number | null; // to be told; null: not now
}

// Pictures five times a second must overlap, and not be smeared: a turn of 60 degrees a second moves a picture by a fifth
// of its width from one to the next.
export const kMostDegrees_s = 60;
export const kMostMetres_s = 0.8; // a stroll
export const kLastsMs: Record<Advice, number> = { slower: 600, lost: 1500, no_depth: 3000, turned: 1000 };
export const kAgainMs = 6000; // the same advice
export const kTellEvery = 40; // pictures
export const kMeanOverMs = 600; // of speed

interface Moment {
  t: number;
  pose: FramePose;
}

export class WalkCoach {
  private moments: Moment[] = [];
  private trouble: Advice | null = null;
  private since = 0;
  private said: Advice | null = null;
  private saidAt = -Infinity;
  private told = 0; // pictures

  // With every picture that was taken; `pictures`: that the computer has stored.
  see(taken: { t: number; pose: FramePose | null; hasDepth: boolean; isTurned: boolean }, pictures: number): WalkNews {
    const trouble = this.troubleOf(taken);
    if (trouble !== this.trouble) {
      this.trouble = trouble;
      this.since = taken.t;
    }
    const advice = this.adviceNow(taken.t);
    const isBetter = advice === null && this.said !== null && trouble === null && taken.t - this.since >= kLastsMs.lost;
    const wasLost = isBetter && this.said !== 'slower'; // that it is slow enough now needs no word
    if (isBetter) {
      this.said = null;
    }
    return { advice, isBetter: wasLost, pictures: this.picturesNow(pictures, advice !== null) };
  }

  private troubleOf({ t, pose, hasDepth, isTurned }: { t: number; pose: FramePose | null; hasDepth: boolean; isTurned: boolean }): Advice | null {
    if (!pose) {
      this.moments = [];
      return 'lost';
    }
    this.moments.push({ t, pose });
    this.moments = this.moments.filter((one) => t - one.t <= kMeanOverMs);
    if (isTurned) {
      return 'turned';
    }
    if (this.isTooFast()) {
      return 'slower';
    }
    return hasDepth ? null : 'no_depth';
  }

  private isTooFast(): boolean {
    const [before, after] = [this.moments[0], this.moments[this.moments.length - 1]];
    if (!before || !after || after.t <= before.t) {
      return false;
    }
    const seconds = (after.t - before.t) / 1000;
    return metresBetween(before.pose, after.pose) / seconds > kMostMetres_s
      || degreesBetween(before.pose, after.pose) / seconds > kMostDegrees_s;
  }

  private adviceNow(t: number): Advice | null {
    if (this.trouble === null || t - this.since < kLastsMs[this.trouble]) {
      return null;
    }
    if (this.said === this.trouble && t - this.saidAt < kAgainMs) {
      return null;
    }
    this.said = this.trouble;
    this.saidAt = t;
    return this.trouble;
  }

  private picturesNow(pictures: number, isSaidAnyway: boolean): number | null {
    const isDue = Math.floor(pictures / kTellEvery) > Math.floor(this.told / kTellEvery);
    if (!isDue && !(isSaidAnyway && pictures > 0)) {
      return null;
    }
    this.told = pictures;
    return pictures;
  }
}

function metresBetween(a: FramePose, b: FramePose): number {
  return Math.hypot(...a.position.map((value, i) => value - (b.position[i] ?? 0)));
}

function degreesBetween(a: FramePose, b: FramePose): number {
  const dot = a.rotation_xyzw.reduce((sum, value, i) => sum + value * (b.rotation_xyzw[i] ?? 0), 0);
  return (2 * Math.acos(Math.min(1, Math.abs(dot))) * 180) / Math.PI;
}
