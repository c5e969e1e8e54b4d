import assert from 'node:assert/strict';
import { test } from 'node:test';

import type { Plan, Point } from '../../shared/protocol';
import { isInside, labelPlace, lineWithLeft, pathOf, roomAt, spanOf } from './plan_geometry';

const square = (x: number, y: number, side: number): Point[] => [[x, y], [x + side, y], [x + side, y + side], [x, y + side]];
const plan: Plan = {
  rooms: [
    { name: 'hall', polygons: [[square(0, 0, 4), square(1, 1, 1)]] },
    { name: 'kitchen', polygons: [[square(4, 0, 2)]] },
  ],
  doors: [{ rooms: ['hall', 'kitchen'], middle: [4, 1], width_m: 0.8 }],
};

test('a point is of the room that it lies in, and in a hole of none', () => {
  assert.equal(roomAt(plan, [0.5, 0.5]), 'hall');
  assert.equal(roomAt(plan, [1.5, 1.5]), null);
  assert.equal(roomAt(plan, [5, 1]), 'kitchen');
  assert.equal(roomAt(plan, [9, 9]), null);
  assert.equal(isInside([], [0, 0]), false);
});

test('the plan spans all that is drawn, with a margin', () => {
  const span = spanOf(plan, null);
  assert.deepEqual([span.left, span.bottom], [-0.4, -0.4]);
  assert.ok(Math.abs(span.width - 6.8) < 1e-9 && Math.abs(span.height - 4.8) < 1e-9);
  assert.deepEqual(spanOf({ rooms: [], doors: [] }, null), { left: 0, bottom: 0, width: 1, height: 1 });
});

test('a name stands inside its room, where that is widest', () => {
  const place = labelPlace(plan.rooms[0]?.polygons ?? []);
  assert.ok(place && isInside(plan.rooms[0]?.polygons[0] ?? [], place.at));
  assert.ok(place.width > 3);
  assert.equal(labelPlace([]), null);
});

test('the third point says which side of a line is meant', () => {
  assert.deepEqual(lineWithLeft([[0, 0], [0, 2], [-1, 1]]), [[0, 0], [0, 2]]);
  assert.deepEqual(lineWithLeft([[0, 0], [0, 2], [1, 1]]), [[0, 2], [0, 0]]);
  assert.deepEqual(lineWithLeft([[0, 0], [0, 2]]), []);
});

test('a path has y down, as pictures have', () => {
  assert.equal(pathOf([[square(0, 0, 1)]]), 'M0 0L1 0L1 -1L0 -1Z');
});
