// When the camera's trouble is worth saying: once it has lasted, and again only after it got better. Pure.
import type { CameraTrouble as PictureTrouble } from '../shared/picture_quality';

export type CameraTrouble = PictureTrouble | 'failed'; // failed: no pictures come, though they did

export const kLastsMs: Record<CameraTrouble, number> = { dark: 1200, covered: 1200, blurred: 2500, failed: 1200 };
export const kBetterAfterMs = 1500;

export type CameraNews = CameraTrouble | 'better' | null;

export class CameraWatch {
  private said: CameraTrouble | null = null; // not yet better
  private trouble: CameraTrouble | null = null; // of the newest pictures
  private since = 0;

  // `trouble` of the newest picture; what is to be said now.
  see(trouble: CameraTrouble | null, now: number): CameraNews {
    if (trouble !== this.trouble) {
      this.trouble = trouble;
      this.since = now;
    }
    const lasted = now - this.since;
    if (trouble === null) {
      return this.said && lasted >= kBetterAfterMs ? this.betterNow() : null;
    }
    // No pictures are worth saying after dark ones, too; of the others one is like the other.
    const isNews = this.said === null || (trouble === 'failed' && this.said !== 'failed');
    if (isNews && lasted >= kLastsMs[trouble]) {
      this.said = trouble;
      return trouble;
    }
    return null;
  }

  get troubled(): CameraTrouble | null {
    return this.said;
  }

  // A picture that was blurred and is not is nothing to speak of; one that was dark is.
  private betterNow(): CameraNews {
    const was = this.said;
    this.said = null;
    return was === 'blurred' ? null : 'better';
  }
}
