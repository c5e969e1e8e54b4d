import assert from 'node:assert/strict';
import { readFileSync } from 'node:fs';
import { test } from 'node:test';

import type { Plan, Point } from '../../shared/protocol';
import { drawn, isInside, labelPlace, lineWithLeft, pathOf, planned, roomAt, spanOf } from './plan_geometry';

const square = (x: number, y: number, side: number): Point[] => [[x, y], [x + side, y], [x + side, y + side], [x, y + side]];
const plan: Plan = {
  rooms: [
    { name: 'hall', polygons: [[square(0, 0, 4), square(1, 1, 1)]] },
    { name: 'kitchen', polygons: [[square(4, 0, 2)]] },
  ],
  doors: [{ rooms: ['hall', 'kitchen'], middle: [4, 1], width_m: 0.8, door: true }],
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

test('what lies to the right on the drawing does so, and a place is found again', () => {
  const turned = { ...plan, right_degrees: 90 };
  const [x, y] = drawn([0, 2], turned);
  assert.ok(Math.abs(x - 2) < 1e-9 && Math.abs(y) < 1e-9);
  const [backX, backY] = planned(drawn([1.5, -0.25], turned), turned);
  assert.ok(Math.abs(backX - 1.5) < 1e-9 && Math.abs(backY + 0.25) < 1e-9);
  const span = spanOf(turned, null);
  assert.ok(Math.abs(span.width - 4.8) < 1e-9 && Math.abs(span.height - 6.8) < 1e-9, 'the longer side stands upright now');
});

test('rooms have the colours that the report and the drawn plan have, made light', () => {
  const colours = readFileSync('../roomwise/evaluation/drawing/svg.cpp', 'utf8');
  const styles = readFileSync('src/styles/helper.css', 'utf8');
  for (let i = 0; i < 8; i += 1) {
    const strong = new RegExp(`dot-${i} \\{ fill: #(\\w{6})`).exec(colours)?.[1] ?? '';
    const light = [0, 2, 4].map((at) => Math.round(0.3 * parseInt(strong.slice(at, at + 2), 16) + 0.7 * 255).toString(16).padStart(2, '0'));
    assert.match(styles, new RegExp(`tone-${i} \\{ fill: #${light.join('')}`));
  }
});
