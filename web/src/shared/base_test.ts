import assert from 'node:assert/strict';
import { test } from 'node:test';
import { at, baseOf } from './base';

test('a home among many has its pages and requests under its own address', () => {
  assert.equal(baseOf('/homes/flat-7/device'), '/homes/flat-7');
  assert.equal(baseOf('/homes/flat-7/'), '/homes/flat-7');
  assert.equal(baseOf('/homes/flat-7'), '');
  assert.equal(baseOf('/device'), '');
  assert.equal(baseOf('/'), '');
  assert.equal(baseOf('/device/homes/flat-7/'), '');
  assert.equal(at('/api/me'), '/api/me');
});
