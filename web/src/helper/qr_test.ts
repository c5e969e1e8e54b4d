import assert from 'node:assert/strict';
import { test } from 'node:test';

import { qrPath } from './qr';

test('runs of dark modules become bars, inside a light border', () => {
  const { side, path } = qrPath(['110', '001', '000']);
  assert.equal(side, 11);
  assert.equal(path, 'M4 4h2v1h-2zM6 5h1v1h-1z');
});
