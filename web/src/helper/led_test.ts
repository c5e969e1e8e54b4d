import assert from 'node:assert/strict';
import { test } from 'node:test';

import type { Plan } from '../shared/protocol';
import { setLanguage } from '../shared/texts';
import { isStale, ledWords, placeAge } from './led';
import type { Watched } from './store';

const plan: Plan = { rooms: [{ name: 'kitchen', polygons: [[[[0, 0], [3, 0], [3, 3], [0, 3]]]] }], doors: [] };
const walk = {
  language: 'en' as const, goal: 'bed', state: 'on_way' as const, person: { t: 900, x: 1, y: 1, heading_degrees: 0, sigma_m: 0.1 },
  left_m: 3.24, way: [], said: [],
};
const watched: Watched = { type: 'led_walk', device: 3, name: 'phone', t: 1000, may_watch: true, walk, received: 50_000 };

test('one line says what the drawing shows', () => {
  setLanguage('en');
  assert.equal(ledWords(watched, walk, plan, 50_100), 'kitchen · to: bed · 3.2 m to go · on the way');
  assert.equal(ledWords(watched, { ...walk, person: null, left_m: null, state: 'lost' }, plan, 50_100), 'place not known yet · to: bed · position lost');
  assert.equal(ledWords(watched, { ...walk, person: { ...walk.person, x: 9 } }, plan, 50_100), 'in no room · to: bed · 3.2 m to go · on the way');
});

test('a place is as old as its picture was when it was told, and then older; after two seconds it is said', () => {
  assert.equal(placeAge(watched, 50_000), 100);
  assert.equal(isStale(watched, 51_900), false);
  assert.equal(isStale(watched, 51_901), true);
  assert.match(ledWords(watched, walk, plan, 53_000), /seen 3 s ago$/);
  assert.equal(placeAge({ ...watched, walk: null }, 50_000), null);
});
