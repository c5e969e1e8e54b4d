import assert from 'node:assert/strict';
import { test } from 'node:test';

import { codeFrom, secretFrom } from './code';

test('a code is six digits, however they are grouped', () => {
  for (const written of ['123456', '#123456', '123 456', '12-34-56', ' 123456 ']) {
    assert.equal(codeFrom(written), '123456', written);
  }
  for (const written of ['', '#', '12345', '1234567', '12345a', '##123456']) {
    assert.equal(codeFrom(written), null, written);
  }
});

test('a link has a secret behind #, and nothing else is one', () => {
  assert.equal(secretFrom('#AbCdEfGhIjKlMnOpQr_-12'), 'AbCdEfGhIjKlMnOpQr_-12');
  for (const hash of ['', '#', '#123456', 'AbCdEfGhIjKlMnOpQr_-12', '#AbCdEfGhIjKlMnOpQr_-123', '#AbCdEfGhIjKlMnOpQr.-12']) {
    assert.equal(secretFrom(hash), null, hash);
  }
});
