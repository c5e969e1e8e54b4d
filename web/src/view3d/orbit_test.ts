import assert from 'node:assert/strict';
import { test } from 'node:test';

import { eyeOf, kHighest, moved, turned, zoomed, type Orbit } from './orbit';

const kOrbit: Orbit = { target: [1, 2, 0], distance: 10, azimuth: 0, height: 0 };

function near(actual: readonly number[], expected: readonly number[]): void {
  actual.forEach((value, i) => assert.ok(Math.abs(value - (expected[i] ?? NaN)) < 1e-9, `${actual} is not ${expected}`));
}

test('the eye goes about its target and over it', () => {
  near(eyeOf(kOrbit), [11, 2, 0]);
  near(eyeOf(turned(kOrbit, Math.PI / 2)), [1, 12, 0]);
  near(eyeOf(turned(kOrbit, 0, Math.PI / 6)), [1 + 10 * Math.cos(Math.PI / 6), 2, 5]);
  assert.equal(turned(kOrbit, 0, 9).height, kHighest);
});

test('nearer and farther end somewhere', () => {
  assert.equal(zoomed(kOrbit, 0.5, { least: 1, most: 20 }).distance, 5);
  assert.equal(zoomed(kOrbit, 0.01, { least: 1, most: 20 }).distance, 1);
  assert.equal(zoomed(kOrbit, 100, { least: 1, most: 20 }).distance, 20);
});

test('what moves right in the picture moves at right angles to the line of sight', () => {
  near(moved(kOrbit, 3, 0).target, [1, 5, 0]); // the eye looks along -x: its right is +y
  near(moved(kOrbit, 0, 2).target, [-1, 2, 0]);
});
