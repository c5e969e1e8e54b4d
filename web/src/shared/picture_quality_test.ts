import assert from 'node:assert/strict';
import { test } from 'node:test';

import { greyFromRgba, measureQuality, troubleOf, type GreyPicture } from './picture_quality';

const kWidth = 120;
const kHeight = 90;

function picture(level: (x: number, y: number) => number): GreyPicture {
  const levels = new Uint8Array(kWidth * kHeight);
  for (let y = 0; y < kHeight; y += 1) {
    for (let x = 0; x < kWidth; x += 1) {
      levels[y * kWidth + x] = level(x, y);
    }
  }
  return { width: kWidth, height: kHeight, levels };
}

// Pieces of furniture: blocks of different grey with hard edges.
const furniture = (x: number, y: number): number =>
  60 + 35 * ((Math.floor(x / 13) + 2 * Math.floor(y / 11)) % 5);

function blurredOnce(from: GreyPicture): GreyPicture {
  return picture((x, y) => {
    let sum = 0;
    let count = 0;
    for (let v = Math.max(0, y - 4); v <= Math.min(kHeight - 1, y + 4); v += 1) {
      for (let u = Math.max(0, x - 4); u <= Math.min(kWidth - 1, x + 4); u += 1) {
        sum += from.levels[v * kWidth + u] ?? 0;
        count += 1;
      }
    }
    return Math.round(sum / count);
  });
}

const troubleIn = (of: GreyPicture) => troubleOf(measureQuality(of));

test('a room is no trouble, by day or by a weak lamp', () => {
  assert.equal(troubleIn(picture(furniture)), null);
  assert.equal(troubleIn(picture((x, y) => furniture(x, y) / 3)), null);
});

test('black is dark, with the noise of a sensor too', () => {
  assert.equal(troubleIn(picture(() => 0)), 'dark');
  assert.equal(troubleIn(picture((x, y) => (x * 7 + y * 13) % 8)), 'dark');
});

test('one bright surface is a covered camera', () => {
  assert.equal(troubleIn(picture(() => 120)), 'covered');
  assert.equal(troubleIn(picture((x) => 90 + Math.floor(x / 12))), 'covered');
});

test('a room out of focus is blurred', () => {
  assert.equal(troubleIn(blurredOnce(blurredOnce(picture(furniture)))), 'blurred');
});

test('measures are those of the definition', () => {
  const quality = measureQuality(picture((x, y) => ((x + y) % 2 === 0 ? 0 : 200)));
  assert.equal(quality.brightness, 100);
  assert.equal(quality.contrast, 100);
  assert.equal(quality.sharpness, 800 * 800); // ± 4 * 200
  assert.deepEqual(measureQuality({ width: 0, height: 0, levels: new Uint8Array() }), {
    brightness: 0, contrast: 0, sharpness: 0,
  });
});

test('grey weighs the colours as eyes do', () => {
  const rgba = Uint8ClampedArray.of(255, 0, 0, 255, 0, 255, 0, 255, 0, 0, 255, 255, 255, 255, 255, 255);
  assert.deepEqual([...greyFromRgba(rgba, 2, 2).levels], [76, 150, 29, 255]);
});
