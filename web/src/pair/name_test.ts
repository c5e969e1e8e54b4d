import assert from 'node:assert/strict';
import { test } from 'node:test';

import { fieldOf, fitsAsName, kMaxNameBytes } from './name';

test('a name is measured in bytes', () => {
  assert.equal(fitsAsName('a'.repeat(kMaxNameBytes)), true);
  assert.equal(fitsAsName('a'.repeat(kMaxNameBytes + 1)), false);
  assert.equal(fitsAsName('ü'.repeat(kMaxNameBytes / 2)), true);
  assert.equal(fitsAsName('ü'.repeat(kMaxNameBytes / 2 + 1)), false);
});

test('a refusal is told at the field that it is about', () => {
  assert.equal(fieldOf(401, 'this code is wrong or no longer valid'), 'code');
  assert.equal(fieldOf(400, "'name' is too long"), 'name');
  assert.equal(fieldOf(400, "'code' must have six digits"), 'code');
  for (const status of [0, 400, 429, 500]) {
    assert.equal(fieldOf(status, 'something else'), null);
  }
});
