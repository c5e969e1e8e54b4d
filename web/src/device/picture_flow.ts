// Whether new pictures still come: a camera that was taken away shows its last one for ever. Pure.

export const kNoPictureAfterMs = 1000;

export class PictureFlow {
  private newest: number | null = null;
  private since = -Infinity;

  // `newest`: changes with every picture; null: the camera gives none. Whether there was a new one of late.
  see(newest: number | null, now: number): boolean {
    if (newest !== null && newest !== this.newest) {
      this.newest = newest;
      this.since = now;
    }
    return newest !== null && now - this.since < kNoPictureAfterMs;
  }
}
