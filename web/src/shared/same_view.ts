// Whether two small grey copies show the same view: who turned on the spot sees something else. Pure.
import type { GreyPicture } from './picture_quality';

// Mean difference of levels, after what the whole picture got lighter or darker by. Between two pictures of a camera that
// lies still it is the noise, about one level in copies this small.
export const kSameBelow = 4;

export function showsTheSame(a: GreyPicture, b: GreyPicture): boolean {
  if (a.levels.length !== b.levels.length || a.levels.length === 0) {
    return false;
  }
  const meanOf = (picture: GreyPicture): number => picture.levels.reduce((sum, level) => sum + level, 0) / picture.levels.length;
  const lighter = meanOf(b) - meanOf(a);
  let sum = 0;
  for (let i = 0; i < a.levels.length; i += 1) {
    sum += Math.abs((b.levels[i] ?? 0) - (a.levels[i] ?? 0) - lighter);
  }
  return sum / a.levels.length < kSameBelow;
}
