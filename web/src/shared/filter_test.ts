import assert from 'node:assert/strict';
import { test } from 'node:test';

import { matching } from './filter';

test('names are found by any part, whatever the case and accents', () => {
  const names = ['Küche', 'Bad', 'kleines Bad', 'Flur'];
  assert.deepEqual(matching(names, 'bad'), ['Bad', 'kleines Bad']);
  assert.deepEqual(matching(names, ' KUCH '), ['Küche']);
  assert.deepEqual(matching(names, ''), names);
  assert.deepEqual(matching(names, 'x'), []);
});
