import assert from 'node:assert/strict';
import { test } from 'node:test';

import { kLookEveryMs } from './connection_watch';
import { FrameSender, kAcknowledgedWithinMs, kFrameGapMs } from './frame_sender';

test('the next frame waits for the acknowledgement of the last', () => {
  const sender = new FrameSender();
  assert.equal(sender.mayStart(0), true);
  sender.sent(10, 0);
  assert.equal(sender.mayStart(10_000), false);
  sender.acknowledged(9); // of an older connection
  assert.equal(sender.mayStart(10_000), false);
  sender.acknowledged(10);
  assert.equal(sender.mayStart(10_000), true);
});

test('frames keep a distance, none while recording', () => {
  const sender = new FrameSender();
  sender.sent(0, 0);
  sender.acknowledged(0);
  assert.equal(sender.mayStart(kFrameGapMs - 1), false);
  assert.equal(sender.mayStart(kFrameGapMs), true);
  assert.equal(sender.mayStart(1, 0), true);
});

test('a computer that does not acknowledge is noticed within three seconds', () => {
  const sender = new FrameSender();
  assert.equal(sender.stalled(1e6), false);
  sender.sent(0, 100);
  assert.equal(sender.stalled(100 + kAcknowledgedWithinMs - 1), false);
  assert.equal(sender.stalled(100 + kAcknowledgedWithinMs), true);
  assert.ok(kAcknowledgedWithinMs + kLookEveryMs < 3000);
  sender.reset();
  assert.equal(sender.stalled(1e6), false);
});
