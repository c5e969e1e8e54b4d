import assert from 'node:assert/strict';
import { test } from 'node:test';

import { kNoPictureAfterMs, PictureFlow } from './picture_flow';

test('the same picture again and again is none any more, until a new one comes', () => {
  const flow = new PictureFlow();
  assert.equal(flow.see(0.1, 5000), true);
  assert.equal(flow.see(0.1, 5000 + kNoPictureAfterMs - 1), true, 'a slow camera');
  assert.equal(flow.see(0.1, 5000 + kNoPictureAfterMs), false);
  assert.equal(flow.see(0.2, 9000), true);
});

test('a camera that was muted or ended gives none at once', () => {
  const flow = new PictureFlow();
  assert.equal(flow.see(null, 0), false);
  assert.equal(flow.see(0.1, 100), true);
  assert.equal(flow.see(null, 200), false);
  assert.equal(flow.see(0, 300), true, 'started anew, its clock begins again');
});
