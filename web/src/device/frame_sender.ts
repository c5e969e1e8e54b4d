// One frame under way: the next, always the newest, goes when the computer has acknowledged the last. Pure.

export const kFrameGapMs = 250; // between frames, to spare battery and radio
export const kAcknowledgedWithinMs = 2500;

export class FrameSender {
  private underWay: number | null = null; // the frame's t
  private sentAt = -Infinity;

  mayStart(now: number, gapMs = kFrameGapMs): boolean {
    return this.underWay === null && now - this.sentAt >= gapMs;
  }

  sent(t: number, now: number): void {
    this.underWay = t;
    this.sentAt = now;
  }

  acknowledged(t: number): void {
    if (t === this.underWay) {
      this.underWay = null;
    }
  }

  // The computer has been silent for so long that the connection is as good as gone.
  stalled(now: number): boolean {
    return this.underWay !== null && now - this.sentAt >= kAcknowledgedWithinMs;
  }

  reset(): void {
    this.underWay = null;
  }
}
