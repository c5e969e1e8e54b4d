import assert from 'node:assert/strict';
import { test } from 'node:test';

import { boundsOf, cloudFrom } from './cloud';

test('points are read as they are laid out', () => {
  const bytes = new ArrayBuffer(32);
  const view = new DataView(bytes);
  [1.5, -2, 0.25].forEach((value, axis) => view.setFloat32(16 + 4 * axis, value, true));
  new Uint8Array(bytes).set([10, 20, 30, 255], 28);
  const cloud = cloudFrom(bytes);
  assert.equal(cloud.count, 2);
  assert.deepEqual([...cloud.positions], [0, 0, 0, 1.5, -2, 0.25]);
  assert.deepEqual([...cloud.colours], [0, 0, 0, 10, 20, 30]);
});

test('half a point is refused', () => {
  assert.throws(() => cloudFrom(new ArrayBuffer(24)), /24 bytes/);
});

test('bounds hold the home and not what lies far outside', () => {
  const positions: number[] = [];
  for (let i = 0; i < 1000; i += 1) {
    positions.push((i % 100) / 10, 2, 1);
  }
  positions.push(500, 500, 500);
  const { middle, radius } = boundsOf(positions);
  assert.ok(Math.abs(middle[0] - 4.95) < 0.2 && middle[1] === 2 && middle[2] === 1);
  assert.ok(radius > 4 && radius < 5.5);
  assert.deepEqual(boundsOf([]), { middle: [0, 0, 0], radius: 3 });
});
