// What a small grey copy of a picture tells about the camera. Pure.

export interface GreyPicture {
  width: number;
  height: number;
  levels: Uint8Array; // row by row, 0 is black
}

export interface PictureQuality {
  brightness: number; // mean level, 0 to 255
  contrast: number; // standard deviation of the levels
  sharpness: number; // variance of the Laplacian
}

export type CameraTrouble = 'dark' | 'covered' | 'blurred';

// For copies about 120 pixels wide. None of some 470 pictures of walks, real and simulated with a camera's faults,
// falls below these; of the same ones blurred by 24 of 640 pixels all are unsharp.
export const kDarkBelow = 18;
export const kPlainBelow = 6; // contrast of a covered lens, or of one surface
export const kUnsharpBelow = 7;

// RGBA as a canvas gives it; luma as in ITU-R BT.601.
export function greyFromRgba(rgba: Uint8ClampedArray, width: number, height: number): GreyPicture {
  const levels = new Uint8Array(width * height);
  for (let i = 0; i < levels.length; i += 1) {
    const [r, g, b] = [rgba[4 * i] ?? 0, rgba[4 * i + 1] ?? 0, rgba[4 * i + 2] ?? 0];
    levels[i] = Math.round(0.299 * r + 0.587 * g + 0.114 * b);
  }
  return { width, height, levels };
}

export function measureQuality(picture: GreyPicture): PictureQuality {
  const { mean, variance } = momentsOf(picture.levels);
  return {
    brightness: mean,
    contrast: Math.sqrt(variance),
    sharpness: momentsOf(laplacian(picture)).variance,
  };
}

export function troubleOf(quality: PictureQuality): CameraTrouble | null {
  if (quality.brightness < kDarkBelow) {
    return 'dark';
  }
  if (quality.sharpness >= kUnsharpBelow) {
    return null;
  }
  return quality.contrast < kPlainBelow ? 'covered' : 'blurred';
}

// Of the inner pixels.
function laplacian({ width, height, levels }: GreyPicture): Int16Array {
  const values = new Int16Array(Math.max(0, width - 2) * Math.max(0, height - 2));
  const at = (x: number, y: number): number => levels[y * width + x] ?? 0;
  let next = 0;
  for (let y = 1; y + 1 < height; y += 1) {
    for (let x = 1; x + 1 < width; x += 1) {
      values[next] = at(x - 1, y) + at(x + 1, y) + at(x, y - 1) + at(x, y + 1) - 4 * at(x, y);
      next += 1;
    }
  }
  return values;
}

function momentsOf(values: Uint8Array | Int16Array): { mean: number; variance: number } {
  if (values.length === 0) {
    return { mean: 0, variance: 0 };
  }
  let sum = 0;
  let squares = 0;
  for (const value of values) {
    sum += value;
    squares += value * value;
  }
  const mean = sum / values.length;
  return { mean, variance: Math.max(0, squares / values.length - mean * mean) };
}
