import assert from 'node:assert/strict';
import { test } from 'node:test';

import { ConnectionWatch, kLookEveryMs, kSaidAfterMs } from './connection_watch';

test('a loss is said once, and its end', () => {
  const watch = new ConnectionWatch(0);
  assert.equal(watch.online(), null);
  watch.offline(5000);
  assert.equal(watch.look(5000 + kSaidAfterMs - 1), null);
  assert.equal(watch.look(5000 + kSaidAfterMs), 'lost');
  watch.offline(7000); // tries that fail
  assert.equal(watch.look(60_000), null);
  assert.equal(watch.online(), 'back');
  assert.equal(watch.look(70_000), null);
});

test('a loss is said within three seconds', () => {
  assert.ok(kSaidAfterMs + kLookEveryMs < 3000);
});

test('a break that heals at once is not spoken of', () => {
  const watch = new ConnectionWatch(0);
  watch.online();
  watch.offline(1000);
  assert.equal(watch.look(1000 + kSaidAfterMs - 1), null);
  assert.equal(watch.online(), null);
  assert.equal(watch.look(90_000), null);
});

test('a computer that is not there from the beginning is said, too', () => {
  const watch = new ConnectionWatch(0);
  assert.equal(watch.look(kSaidAfterMs), 'lost');
});

test('a silent connection is said at once', () => {
  const watch = new ConnectionWatch(0);
  watch.online();
  assert.equal(watch.gone(), 'lost');
  watch.offline(10);
  assert.equal(watch.look(5000), null);
  assert.equal(watch.online(), 'back');
});
