import assert from 'node:assert/strict';
import { test } from 'node:test';

import type { Priority } from '../shared/protocol';
import { kCalloutGapMs, kSameCalloutMs, kSameHazardMs, PromptQueue, type QueuedPrompt } from './prompt_queue';

function prompt(key: string, priority: Priority, more: Partial<QueuedPrompt> = {}): QueuedPrompt {
  return { key, text: key, language: 'en', priority, sound: 'none', valid_until_t: 1e9, ...more };
}

// The key that is begun at `now`, or what else is to be done.
function begun(queue: PromptQueue, now: number): string {
  const step = queue.step(now);
  return step.do === 'begin' ? step.prompt.key : step.do;
}

function spokenInOrder(queue: PromptQueue, from: number): string[] {
  const keys: string[] = [];
  for (let now = from; ; now += 1000) {
    const key = begun(queue, now);
    if (key === 'nothing') {
      return keys;
    }
    keys.push(key);
    queue.ended(now + 100);
  }
}

test('the most urgent is said first, equals in the order in which they came', () => {
  const queue = new PromptQueue();
  queue.push(prompt('entered', 'callout'), 0);
  queue.push(prompt('dark', 'notice'), 0);
  queue.push(prompt('first', 'answer'), 0);
  queue.push(prompt('second', 'answer'), 0);
  queue.push(prompt('stairs', 'hazard'), 0);
  assert.deepEqual(spokenInOrder(queue, 0), ['stairs', 'first', 'second', 'dark', 'entered']);
});

test('a newer prompt takes the place of a waiting one of the same key, and only of a waiting one', () => {
  const queue = new PromptQueue();
  queue.push(prompt('room', 'answer', { text: 'kitchen' }), 0);
  assert.equal(begun(queue, 0), 'room');
  queue.push(prompt('room', 'answer', { text: 'bathroom' }), 1);
  queue.push(prompt('room', 'answer', { text: 'corridor' }), 2);
  assert.equal(queue.speaking?.text, 'kitchen');
  queue.ended(10);
  const step = queue.step(10);
  assert.equal(step.do === 'begin' && step.prompt.text, 'corridor');
  queue.ended(20);
  assert.equal(begun(queue, 20), 'nothing');
});

test('an answer takes the place of all parts of the one before it', () => {
  const queue = new PromptQueue();
  for (const key of ['around', 'around/2', 'around/3', 'aroundness']) {
    queue.push(prompt(key, 'answer'), 0);
  }
  queue.push(prompt('around', 'answer', { text: 'anew' }), 1);
  queue.push(prompt('around/2', 'answer', { text: 'anew' }), 1);
  assert.deepEqual(spokenInOrder(queue, 2), ['around', 'aroundness', 'around/2']);
});

test('nothing begins after its time, neither on arrival nor after waiting', () => {
  const queue = new PromptQueue();
  assert.equal(queue.push(prompt('late', 'answer', { valid_until_t: 99 }), 100), false);
  assert.equal(queue.push(prompt('soon late', 'answer', { valid_until_t: 200 }), 100), true);
  assert.equal(begun(queue, 201), 'nothing');
  queue.push(prompt('just in time', 'answer', { valid_until_t: 300 }), 250);
  assert.equal(begun(queue, 300), 'just in time');
});

test('only a hazard interrupts, and no hazard another', () => {
  const queue = new PromptQueue();
  queue.push(prompt('room', 'callout'), 0);
  assert.equal(begun(queue, 0), 'room');
  queue.push(prompt('where', 'answer'), 10);
  assert.equal(begun(queue, 10), 'nothing');
  queue.push(prompt('stairs', 'hazard'), 20);
  const step = queue.step(20);
  assert.deepEqual(step.do === 'begin' && [step.prompt.key, step.interrupts], ['stairs', true]);
  queue.push(prompt('door', 'hazard'), 30);
  assert.equal(begun(queue, 30), 'nothing');
  queue.ended(40);
  assert.equal(begun(queue, 40), 'door');
});

test('an answer that was broken off comes again, before its own parts and what was asked later', () => {
  const queue = new PromptQueue();
  for (const key of ['around', 'around/2', 'where']) {
    queue.push(prompt(key, 'answer'), 0);
  }
  assert.equal(begun(queue, 0), 'around');
  queue.push(prompt('stairs', 'hazard'), 10);
  assert.deepEqual(spokenInOrder(queue, 10), ['stairs', 'around', 'around/2', 'where']);
});

test('an answer that was broken off does not come again where it is outdated, withdrawn or past its time', () => {
  const afterHazard = (meanwhile: (queue: PromptQueue) => void): string[] => {
    const queue = new PromptQueue();
    queue.push(prompt('room', 'answer', { text: 'kitchen', valid_until_t: 5000 }), 0);
    assert.equal(begun(queue, 0), 'room');
    queue.push(prompt('stairs', 'hazard'), 10);
    assert.equal(begun(queue, 10), 'stairs');
    meanwhile(queue);
    queue.ended(4000);
    return spokenInOrder(queue, 4000);
  };
  assert.deepEqual(afterHazard(() => undefined), ['room']);
  assert.deepEqual(afterHazard((queue) => queue.push(prompt('room', 'answer', { text: 'corridor' }), 20)), ['room']);
  assert.deepEqual(afterHazard((queue) => queue.withdrawAnswers()), []);
  const late = new PromptQueue();
  late.push(prompt('room', 'answer', { valid_until_t: 100 }), 0);
  assert.equal(begun(late, 0), 'room');
  late.push(prompt('stairs', 'hazard'), 10);
  assert.deepEqual(spokenInOrder(late, 10).concat(late.takeLost(9000) ? ['lost'] : []), ['stairs']);
});

test('between two callouts lie 0.75 s, counted from the end of the first', () => {
  const queue = new PromptQueue();
  queue.push(prompt('kitchen', 'callout'), 0);
  queue.push(prompt('corridor', 'callout'), 0);
  assert.equal(begun(queue, 0), 'kitchen');
  queue.ended(1000);
  assert.deepEqual(queue.step(1000), { do: 'wait', until: 1000 + kCalloutGapMs });
  assert.equal(begun(queue, 1000 + kCalloutGapMs - 1), 'wait');
  assert.equal(begun(queue, 1000 + kCalloutGapMs), 'corridor');
});

test('an answer does not wait for the gap between callouts', () => {
  const queue = new PromptQueue();
  queue.push(prompt('kitchen', 'callout'), 0);
  begun(queue, 0);
  queue.ended(1000);
  queue.push(prompt('corridor', 'callout'), 1000);
  queue.push(prompt('answer', 'answer'), 1000);
  assert.equal(begun(queue, 1001), 'answer');
});

test('the same callout is not said again within a minute, another text of its key is', () => {
  const queue = new PromptQueue();
  const kitchen = prompt('room', 'callout', { text: 'kitchen' });
  queue.push(kitchen, 0);
  begun(queue, 0);
  queue.ended(500);
  assert.equal(queue.push(kitchen, kSameCalloutMs - 1), false);
  assert.equal(queue.push(prompt('room', 'callout', { text: 'corridor' }), 2000), true);
  assert.equal(begun(queue, 2000), 'room');
  queue.ended(2500);
  assert.equal(queue.push(kitchen, kSameCalloutMs), true);
  assert.equal(begun(queue, kSameCalloutMs), 'room');
});

test('quiet silences callouts, waiting ones too, and nothing else', () => {
  const queue = new PromptQueue();
  queue.push(prompt('kitchen', 'callout'), 0);
  queue.push(prompt('dark', 'notice'), 0);
  queue.setQuiet(true);
  assert.equal(queue.push(prompt('corridor', 'callout'), 0), false);
  queue.push(prompt('room', 'answer'), 0);
  assert.deepEqual(spokenInOrder(queue, 0), ['room', 'dark']);
  queue.setQuiet(false);
  assert.equal(queue.push(prompt('corridor', 'callout'), 5000), true);
});

test('the same hazard, told with every picture, is begun once in four seconds, another one at once', () => {
  const queue = new PromptQueue();
  const begunAt: number[] = [];
  for (let now = 0; now <= 9000; now += 250) {
    queue.push(prompt('ahead', 'hazard', { text: 'Obstacle ahead.', valid_until_t: now + 1000 }), now);
    if (begun(queue, now) === 'ahead') {
      begunAt.push(now);
      queue.ended(now + 100);
    }
  }
  assert.deepEqual(begunAt, [0, kSameHazardMs, 2 * kSameHazardMs]);
  assert.equal(queue.push(prompt('ahead', 'hazard', { text: 'Stairs ahead.' }), 9100), true);
  assert.equal(begun(queue, 9100), 'ahead');
});

test('answers are withdrawn, and nothing else', () => {
  const queue = new PromptQueue();
  for (const key of ['around', 'around/2']) {
    queue.push(prompt(key, 'answer'), 0);
  }
  queue.push(prompt('dark', 'notice'), 0);
  queue.withdrawAnswers();
  assert.deepEqual(spokenInOrder(queue, 0), ['dark']);
  assert.equal(queue.takeLost(5000), false, 'what was withdrawn is not lost');
});

test('an answer that is past its time is lost, the rest of one that was begun is not, nor is anything else', () => {
  const queue = new PromptQueue();
  queue.push(prompt('around', 'answer', { valid_until_t: 100 }), 0);
  queue.push(prompt('around/2', 'answer', { valid_until_t: 100 }), 0);
  queue.push(prompt('dark', 'notice', { valid_until_t: 100 }), 0);
  assert.equal(begun(queue, 50), 'around');
  assert.equal(queue.takeLost(200), false);
  queue.push(prompt('room', 'answer', { valid_until_t: 300 }), 200);
  assert.equal(queue.takeLost(301), true);
  assert.equal(queue.takeLost(302), false, 'once');
  queue.push(prompt('room', 'answer', { valid_until_t: 400 }), 500);
  assert.equal(queue.takeLost(500), true);
});

test('what takes the place of an answer is as urgent, whatever it is itself', () => {
  const queue = new PromptQueue();
  queue.push(prompt('room', 'answer'), 0);
  queue.push(prompt('dark', 'notice'), 0);
  queue.push(prompt('room', 'callout', { text: 'bathroom' }), 1);
  const step = queue.step(2);
  assert.deepEqual(step.do === 'begin' && [step.prompt.text, step.prompt.priority], ['bathroom', 'answer']);
});

test('on any run of prompts: one at a time, none late, callouts spaced and not repeated', () => {
  // A small seeded generator, so that a failure repeats.
  let state = 12345;
  const random = (below: number): number => {
    state = (Math.imul(state, 1103515245) + 12345) >>> 0;
    return Math.floor((state / 2 ** 32) * below);
  };
  const priorities: Priority[] = ['hazard', 'answer', 'notice', 'callout'];
  const queue = new PromptQueue();
  let endsAt = Infinity;
  let lastCalloutEnd = -Infinity;
  const calloutBegun = new Map<string, number>();
  for (let now = 0; now < 600_000; now += 50) {
    if (random(10) === 0) {
      const priority = priorities[random(4)] as Priority;
      const key = `k${random(6)}`;
      queue.push(prompt(key, priority, { valid_until_t: now + random(4000) }), now);
    }
    if (now >= endsAt) {
      if (queue.speaking?.priority === 'callout') {
        lastCalloutEnd = now;
      }
      queue.ended(now);
      endsAt = Infinity;
    }
    const before = queue.speaking;
    const step = queue.step(now);
    if (step.do !== 'begin') {
      continue;
    }
    assert.ok(step.prompt.valid_until_t >= now);
    assert.equal(step.interrupts, before !== null);
    if (before) {
      assert.equal(step.prompt.priority, 'hazard');
      assert.notEqual(before.priority, 'hazard');
      lastCalloutEnd = before.priority === 'callout' ? now : lastCalloutEnd;
    }
    if (step.prompt.priority === 'callout') {
      assert.ok(now - lastCalloutEnd >= kCalloutGapMs);
      const last = calloutBegun.get(step.prompt.text);
      assert.ok(last === undefined || now - last >= kSameCalloutMs);
      calloutBegun.set(step.prompt.text, now);
    }
    endsAt = now + 200 + random(3000);
  }
  assert.ok(calloutBegun.size > 3);
});
