import assert from 'node:assert/strict';
import { test } from 'node:test';

import type { Prompt } from '../shared/protocol';
import { AnswerWatch, kAnsweredWithinMs, kLongMs, kWorthHearingMs } from './answer_watch';
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

test('who waits long for an answer is told to wait, once a question', () => {
  const watch = new AnswerWatch();
  assert.equal(watch.takesLong(1e6), false, 'nothing was asked');
  watch.ask(1, 100);
  assert.equal(watch.takesLong(100 + kLongMs - 1), false);
  assert.equal(watch.takesLong(100 + kLongMs), true);
  assert.equal(watch.takesLong(100 + kLongMs + 1), false);
  watch.ask(2, 10_000);
  watch.heard(2, 10_100);
  assert.equal(watch.takesLong(1e6), false, 'it was answered');
});

test('an answer that comes late is told as what was so; nobody is to walk by it, nor is it told for ever', () => {
  const watch = new AnswerWatch();
  watch.ask(1, 0);
  const answer = (more: Partial<Prompt> = {}): Prompt => ({
    type: 'prompt', answer_to: 1, key: 'where', message: 'room.is', text: 'You are in the kitchen.', language: 'en', priority: 'answer',
    confidence: 'sure', sound: 'answer', because: '', based_on_t: null, valid_until_t: 3000, ...more,
  });
  assert.deepEqual(watch.inTime(answer(), 3000), answer());
  const late = watch.inTime(answer(), 8000);
  assert.equal(late.text, 'Earlier: You are in the kitchen.');
  assert.ok(late.valid_until_t > 8000);
  assert.equal(watch.inTime(answer({ language: 'de', text: 'Sie sind in der Küche.' }), 8000).text, 'Vorhin: Sie sind in der Küche.');
  const part = watch.inTime(answer({ key: 'around/1', text: 'A cup.' }), 8000);
  assert.equal(part.text, 'A cup.');
  assert.ok(part.valid_until_t > 8000);
  const toWalkBy = ['guide.turn', 'route.left', 'ahead.free', 'around.thing', 'where.direction_probable'].map((message) => answer({ message }));
  for (const other of [...toWalkBy, answer({ priority: 'callout' }), answer({ answer_to: null })]) {
    assert.deepEqual(watch.inTime(other, 8000), other);
  }
  assert.deepEqual(watch.inTime(answer(), kWorthHearingMs + 1), answer());
});
