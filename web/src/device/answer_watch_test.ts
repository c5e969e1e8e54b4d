import assert from 'node:assert/strict';
import { test } from 'node:test';

import { AnswerWatch, kAnsweredWithinMs } from './answer_watch';
import { kLookEveryMs } from './connection_watch';

test('a question to which nothing is said is noticed within three seconds', () => {
  const watch = new AnswerWatch();
  assert.equal(watch.silent(1e6), false, 'nothing was asked');
  watch.ask(1, 100);
  assert.equal(watch.silent(100 + kAnsweredWithinMs - 1), false);
  assert.equal(watch.silent(100 + kAnsweredWithinMs), true);
  assert.ok(kAnsweredWithinMs + kLookEveryMs < 3000);
  watch.reset();
  assert.equal(watch.silent(1e6), false);
});

test('what was answered is not waited for', () => {
  const watch = new AnswerWatch();
  watch.ask(1, 0);
  watch.heard(1, 2000);
  assert.equal(watch.silent(1e6), false);
});

test('a computer that takes long, but is heard of, is there', () => {
  const watch = new AnswerWatch();
  watch.ask(1, 0);
  watch.heard(null, 2000); // a frame has arrived
  watch.heard(0, 3000); // the answer to an older question
  assert.equal(watch.silent(3000 + kAnsweredWithinMs - 1), false);
  assert.equal(watch.silent(3000 + kAnsweredWithinMs), true);
});

test('who asks again and again hears of the loss as soon', () => {
  const watch = new AnswerWatch();
  [0, 1000, 2000].forEach((now, i) => watch.ask(i, now));
  assert.equal(watch.silent(kAnsweredWithinMs), true);
});
