import assert from 'node:assert/strict';
import { test } from 'node:test';

import type { GreyPicture } from './picture_quality';
import { showsTheSame } from './same_view';

function stripes(shift: number, lighter = 0, noise = 0): GreyPicture {
  const levels = Uint8Array.from({ length: 120 * 90 }, (_, i) => ((i % 120) + shift) % 40 < 20 ? 80 + lighter + (i % 3) * noise : 160 + lighter);
  return { width: 120, height: 90, levels };
}

test('a camera that lies still shows the same, also with noise and another exposure', () => {
  assert.equal(showsTheSame(stripes(0), stripes(0)), true);
  assert.equal(showsTheSame(stripes(0), stripes(0, 12, 2)), true);
});

test('who turned shows something else, and so does a picture of another shape', () => {
  assert.equal(showsTheSame(stripes(0), stripes(8)), false);
  assert.equal(showsTheSame(stripes(0), { width: 90, height: 120, levels: new Uint8Array(90 * 120).fill(1).subarray(1) }), false);
});
