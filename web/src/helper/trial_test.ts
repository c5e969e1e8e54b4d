import assert from 'node:assert/strict';
import { test } from 'node:test';

import { messages as spoken } from '../../../roomwise/guide/messages/en.json';
import { makePlan } from '../../test/made_up_home';
import { kSaidAlong, kSaidOfWay, kSaidWithoutPlace } from '../../test/stand_in_api';
import type { Point } from '../shared/protocol';
import { headingOf, roomsOnWay, wayWords } from './trial';

const kWay: Point[] = [[4.5, 2.5], [4, 1.4], [1.5, 1.2], [1.5, 3]];

test('a way is told by its length and the rooms through which it leads', () => {
  assert.deepEqual(roomsOnWay(kWay, makePlan()), ['bathroom', 'corridor', 'kitchen']);
  assert.equal(wayWords(kWay, makePlan()), 'The way that they would be led: 5.5 m, through bathroom, corridor, kitchen.');
  assert.equal(wayWords([[90, 90], [91, 90]], makePlan()), 'The way that they would be led: 1 m.');
  assert.deepEqual(roomsOnWay([], makePlan()), []);
});

test('who sets one point looks up, who sets two looks from the first to the second', () => {
  assert.equal(headingOf([[1, 1]], makePlan()), 90);
  assert.equal(headingOf([[1, 1]], { ...makePlan(), right_degrees: 30 }), 120, 'up on a drawing that is turned');
  assert.equal(headingOf([[1, 1], [2, 1]], makePlan()), 0);
  assert.equal(headingOf([[1, 1], [1, 0]], makePlan()), -90);
});

test('what the made-up home answers are sentences that the program says', () => {
  const sentences = Object.values(spoken).filter((one) => /^[A-Z]/.test(one))
    .map((one) => one.replace(/[.*+?^$()|[\]\\]/g, '\\$&').replace(/\{[^}]*\}/g, '[^.:]+'));
  const said = new RegExp(`^(?:(?:${sentences.join('|')})(?: |$))+$`);
  for (const words of [...kSaidOfWay, ...kSaidAlong, ...kSaidWithoutPlace]) {
    assert.match(words, said);
  }
  assert.doesNotMatch('To the microwave, 6 metres.', said);
});
