import assert from 'node:assert/strict';
import { test } from 'node:test';

import type { DeviceSeen, Home, Plan, Storey } from './protocol';
import { devicesInSpace, levelOf, onStorey, storeyAt } from './storeys';

const storeys: Storey[] = [
  { from_x: null, plan_from_level: [0, 0], floor_m: 0 },
  { from_x: 10, plan_from_level: [12, 0], floor_m: 2.8 },
];
const thing = (name: string, x: number) => ({ name, position: [x, 1, 0.5] }) as unknown as Home['things'][number];
const home = { storeys, things: [thing('sofa', 2), thing('bed', 14), { ...thing('lamp', 0), position: null }] } as unknown as Home;
const plan: Plan = {
  rooms: [{ name: 'hall', polygons: [[[[0, 0], [1, 0], [1, 1]]]] }, { name: 'landing', polygons: [[[[12, 0], [13, 0], [13, 1]]]] }],
  doors: [{ rooms: ['hall', 'hall'], middle: [1, 0], width_m: 1, door: true }, { rooms: ['landing', 'landing'], middle: [13, 0], width_m: 1, door: true }],
};

test('a place of the plan is on the storey that is drawn there', () => {
  assert.deepEqual([storeyAt(storeys, -3), storeyAt(storeys, 9.9), storeyAt(storeys, 10)], [0, 0, 1]);
  assert.equal(storeyAt([], 5), 0);
});

test('in space storeys lie above one another', () => {
  assert.deepEqual(levelOf(storeys, [2, 1, 0.5]), [2, 1, 0.5]);
  assert.deepEqual(levelOf(storeys, [14, 1, 0.5]), [2, 1, 3.3]);
  assert.deepEqual(levelOf([], [14, 1, 0.5]), [14, 1, 0.5]);
  const seen = [{ name: 'phone', seen: { position: { x: 14, y: 1, z: 1.4, heading_degrees: 90, sigma_m: 0.1 } } }] as unknown as DeviceSeen[];
  assert.equal(devicesInSpace(home, seen)[0]?.seen?.position?.x, 2);
  assert.equal(devicesInSpace(null, seen)[0]?.seen?.position?.x, 14);
});

test('a storey holds its rooms, doors and things alone', () => {
  const upper = onStorey(plan, home, 1);
  assert.deepEqual(upper.plan.rooms.map(({ name }) => name), ['landing']);
  assert.equal(upper.plan.doors.length, 1);
  assert.deepEqual(upper.home.things.map(({ name }) => name), ['bed']);
});

test('a home of one storey is drawn whole', () => {
  const one = { ...home, storeys: undefined } as unknown as Home;
  assert.equal(onStorey(plan, one, 0).plan, plan);
  assert.equal(onStorey(plan, one, 0).home, one);
});
