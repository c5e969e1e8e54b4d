import assert from 'node:assert/strict';
import { test } from 'node:test';

import { codeFrom } from './code';

test('a code is six digits, however they are grouped', () => {
  for (const written of ['123456', '#123456', '123 456', '12-34-56', ' 123456 ']) {
    assert.equal(codeFrom(written), '123456', written);
  }
  for (const written of ['', '#', '12345', '1234567', '12345a', '##123456']) {
    assert.equal(codeFrom(written), null, written);
  }
});
