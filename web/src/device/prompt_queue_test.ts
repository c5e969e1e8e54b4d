import assert from 'node:assert/strict';
import { test } from 'node:test';

import type { Priority } from '../shared/protocol';
import { kCalloutGapMs, kSameCalloutMs, kSameHazardMs, PromptQueue, type QueuedPrompt } from './prompt_queue';

function prompt(key: string, priority: Priority, more: Partial<QueuedPrompt> = {}): QueuedPrompt {
  return { key, text: key, language: 'en', priority, sound: 'none', valid_until_t: 1e9, answer_to: priority === 'answer' ? 1 : null, ...more };
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

// The text that is begun at `now` and spoken for half a second; nothing: ''.
function speak(queue: PromptQueue, now: number): string {
  const step = queue.step(now);
  if (step.do !== 'begin') {
    return '';
  }
  queue.ended(now + 500);
  return step.prompt.text;
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
  queue.push(prompt('late', 'answer', { valid_until_t: 99 }), 100);
  assert.equal(begun(queue, 100), 'nothing');
  queue.push(prompt('soon late', 'answer', { valid_until_t: 200 }), 100);
  assert.equal(begun(queue, 201), 'nothing');
  queue.push(prompt('just in time', 'answer', { valid_until_t: 300 }), 250);
  assert.equal(begun(queue, 300), 'just in time');
});

test('a hazard interrupts, and no hazard another', () => {
  const queue = new PromptQueue();
  queue.push(prompt('room', 'callout'), 0);
  assert.equal(begun(queue, 0), 'room');
  queue.push(prompt('dark', 'notice'), 10);
  assert.equal(begun(queue, 10), 'nothing');
  queue.push(prompt('stairs', 'hazard'), 20);
  const step = queue.step(20);
  assert.deepEqual(step.do === 'begin' && [step.prompt.key, step.interrupts], ['stairs', true]);
  queue.push(prompt('door', 'hazard'), 30);
  assert.equal(begun(queue, 30), 'nothing');
  queue.ended(40);
  assert.equal(begun(queue, 40), 'door');
});

test('an answer that was broken off comes again, before its own parts and what came after those', () => {
  const queue = new PromptQueue();
  for (const key of ['around', 'around/2', 'where']) {
    queue.push(prompt(key, 'answer'), 0);
  }
  assert.equal(begun(queue, 0), 'around');
  queue.push(prompt('stairs', 'hazard'), 10);
  assert.deepEqual(spokenInOrder(queue, 10), ['stairs', 'around', 'around/2', 'where']);
  queue.push(prompt('room', 'answer'), 60_000);
  queue.push(prompt('where', 'answer'), 60_000);
  assert.equal(begun(queue, 60_000), 'room');
  queue.push(prompt('stairs', 'hazard'), 60_010);
  assert.deepEqual(spokenInOrder(queue, 60_010), ['stairs', 'where', 'room']);
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

test('what a newer word on the same broke off does not come again', () => {
  for (const [key, again] of [['guide', []], ['stairs', ['guide/2']]] as const) {
    const queue = new PromptQueue();
    queue.push(prompt('guide/2', 'answer'), 0);
    assert.equal(begun(queue, 0), 'guide/2');
    queue.push(prompt(key, 'hazard'), 10);
    assert.deepEqual(spokenInOrder(queue, 10), [key, ...again]);
  }
});

test('before a callout lie 0.75 s of silence, whatever was said last and however that ended', () => {
  for (const priority of ['callout', 'answer', 'notice', 'hazard'] as const) {
    const queue = new PromptQueue();
    queue.push(prompt('first', priority), 0);
    assert.equal(begun(queue, 0), 'first', 'before the first there was silence');
    queue.push(prompt('corridor', 'callout'), 0);
    queue.ended(1000);
    assert.deepEqual(queue.step(1000), { do: 'wait', until: 1000 + kCalloutGapMs });
    assert.equal(begun(queue, 1000 + kCalloutGapMs - 1), 'wait');
    assert.equal(begun(queue, 1000 + kCalloutGapMs), 'corridor');
  }
});

test('a callout that runs out before its silence is over is not waited for', () => {
  const queue = new PromptQueue();
  queue.push(prompt('room', 'answer'), 0);
  assert.equal(begun(queue, 0), 'room');
  queue.push(prompt('corridor', 'callout', { valid_until_t: 1000 + kCalloutGapMs - 1 }), 0);
  queue.ended(1000);
  assert.equal(begun(queue, 1000), 'nothing');
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
  queue.push(prompt('room', 'callout', { text: 'corridor' }), 2000);
  assert.equal(speak(queue, 2000), 'corridor');
  queue.push(kitchen, kSameCalloutMs - 1);
  assert.equal(speak(queue, kSameCalloutMs - 1), '');
  assert.equal(speak(queue, 2 * kSameCalloutMs), '', 'it did not wait for the minute to end');
  queue.push(kitchen, 2 * kSameCalloutMs);
  assert.equal(speak(queue, 2 * kSameCalloutMs), 'kitchen');
});

test('a callout that is not said again still outdates the one that waits', () => {
  const queue = new PromptQueue();
  queue.push(prompt('room', 'callout', { text: 'kitchen' }), 0);
  assert.equal(speak(queue, 0), 'kitchen');
  queue.push(prompt('room', 'callout', { text: 'hall' }), 600);
  queue.push(prompt('room', 'callout', { text: 'kitchen' }), 700);
  assert.equal(speak(queue, 2000), '');
});

test('questions are always answered, and what an answer has just said is not called out', () => {
  const queue = new PromptQueue();
  for (const now of [0, 1000, 2000]) {
    queue.push(prompt('room', 'answer', { text: 'kitchen' }), now);
    assert.equal(speak(queue, now), 'kitchen');
  }
  queue.push(prompt('room', 'callout', { text: 'kitchen' }), 5000);
  assert.equal(speak(queue, 5000), '');
});

test('quiet silences callouts, waiting ones too, and nothing else', () => {
  const queue = new PromptQueue();
  queue.push(prompt('kitchen', 'callout'), 0);
  queue.push(prompt('dark', 'notice'), 0);
  queue.setQuiet(true);
  queue.push(prompt('corridor', 'callout'), 0);
  queue.push(prompt('room', 'answer'), 0);
  assert.deepEqual(spokenInOrder(queue, 0), ['room', 'dark']);
  queue.setQuiet(false);
  queue.push(prompt('corridor', 'callout'), 5000);
  assert.equal(begun(queue, 5000), 'corridor');
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
  queue.push(prompt('ahead', 'hazard', { text: 'Stairs ahead.' }), 9100);
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

test('an answer that was never begun in its time is lost; what was begun or replaced is not, nor is anything else', () => {
  const queue = new PromptQueue();
  queue.push(prompt('dark', 'notice'), 0);
  assert.equal(begun(queue, 0), 'dark');
  queue.push(prompt('room', 'answer', { valid_until_t: 300 }), 100);
  queue.push(prompt('other', 'answer', { valid_until_t: 300 }), 100);
  queue.push(prompt('other', 'answer', { text: 'newer' }), 200);
  queue.push(prompt('hall', 'callout', { valid_until_t: 300 }), 100);
  assert.equal(queue.takeLost(300), false);
  assert.equal(queue.takeLost(301), true);
  assert.equal(queue.takeLost(302), false, 'once');
  queue.ended(400);
  const step = queue.step(400);
  assert.equal(step.do === 'begin' && step.prompt.text, 'newer');
  queue.push(prompt('stairs', 'hazard'), 500);
  assert.equal(begun(queue, 500), 'stairs');
  assert.equal(queue.takeLost(2e9), false, 'it was begun at least');
  queue.push(prompt('room', 'answer', { valid_until_t: 400 }), 500);
  assert.equal(queue.takeLost(500), true, 'it came too late');
});

test('what a guide says by itself is no answer that somebody misses, but where it took the place of one', () => {
  const queue = new PromptQueue();
  queue.push(prompt('rooms', 'answer'), 0);
  assert.equal(begun(queue, 0), 'rooms');
  queue.push(prompt('guide', 'answer', { answer_to: null, valid_until_t: 100 }), 10);
  assert.equal(queue.takeLost(200), false);
  queue.push(prompt('guide', 'answer', { valid_until_t: 400 }), 300);
  queue.push(prompt('guide', 'answer', { answer_to: null, valid_until_t: 400 }), 310);
  assert.equal(queue.takeLost(500), true);
});

test('an answer interrupts a notice or callout, since it holds for seconds; a guide that nobody asked does not', () => {
  const queue = new PromptQueue();
  queue.push(prompt('hall', 'callout'), 0);
  assert.equal(begun(queue, 0), 'hall');
  queue.push(prompt('guide', 'answer', { answer_to: null }), 100);
  assert.equal(begun(queue, 100), 'nothing');
  queue.push(prompt('room', 'answer', { valid_until_t: 3000 }), 150);
  const step = queue.step(150);
  assert.equal(step.do === 'begin' && step.prompt.key, 'room');
  assert.equal(step.do === 'begin' && step.interrupts, true);
  queue.push(prompt('other', 'answer'), 200);
  assert.equal(begun(queue, 200), 'nothing', 'one answer does not interrupt another');
  queue.ended(300);
  assert.deepEqual(spokenInOrder(queue, 300), ['guide', 'other']);
  queue.push(prompt('dark', 'notice'), 5000);
  assert.equal(begun(queue, 5000), 'dark');
  queue.push(prompt('room', 'answer'), 5100);
  assert.deepEqual(spokenInOrder(queue, 5100), ['room', 'dark'], 'the notice is said again');
});

test('the rest of an answer that could not be begun is lost like a whole one', () => {
  const queue = new PromptQueue();
  queue.push(prompt('around', 'answer', { valid_until_t: 100 }), 0);
  queue.push(prompt('around/2', 'answer', { valid_until_t: 100 }), 0);
  assert.equal(begun(queue, 50), 'around');
  assert.equal(queue.takeLost(200), true);
});

test('what takes the place of an answer, or of a part of one, is as urgent and as early, whatever it is itself', () => {
  for (const key of ['room', 'room/2']) {
    const queue = new PromptQueue();
    queue.push(prompt(key, 'answer'), 0);
    queue.push(prompt('where', 'answer'), 0);
    queue.push(prompt('dark', 'notice'), 0);
    queue.setQuiet(true);
    queue.push(prompt('room', 'callout', { text: 'bathroom' }), 1);
    const step = queue.step(2);
    assert.deepEqual(step.do === 'begin' && [step.prompt.text, step.prompt.priority], ['bathroom', 'answer']);
  }
});

test('nothing is made urgent by an answer that had run out', () => {
  const queue = new PromptQueue();
  queue.push(prompt('room', 'answer', { valid_until_t: 100 }), 0);
  queue.push(prompt('dark', 'notice'), 0);
  queue.push(prompt('room', 'callout', { text: 'bathroom' }), 101);
  assert.equal(speak(queue, 101), 'dark');
});

test('on any run of prompts: one at a time, none late, callouts after silence and not repeated', () => {
  // A small seeded generator, so that a failure repeats.
  let state = 12345;
  const random = (below: number): number => {
    state = (Math.imul(state, 1103515245) + 12345) >>> 0;
    return Math.floor((state / 2 ** 32) * below);
  };
  const priorities: Priority[] = ['hazard', 'answer', 'notice', 'callout'];
  const queue = new PromptQueue();
  let endsAt = Infinity;
  let lastEnd = -Infinity;
  let callouts = 0;
  const lastBegun = new Map<string, number>();
  for (let now = 0; now < 600_000; now += 50) {
    if (random(10) === 0) {
      const priority = priorities[random(4)] as Priority;
      const key = `k${random(60)}`;
      queue.push(prompt(key, priority, { valid_until_t: now + random(4000) }), now);
    }
    if (now >= endsAt) {
      queue.ended(now);
      lastEnd = now;
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
      assert.ok(['hazard', 'answer'].includes(step.prompt.priority));
      assert.ok(priorities.indexOf(before.priority) > priorities.indexOf(step.prompt.priority));
      lastEnd = now;
    }
    if (step.prompt.priority === 'callout') {
      assert.ok(now - lastEnd >= kCalloutGapMs);
      assert.ok(now - (lastBegun.get(step.prompt.text) ?? -Infinity) >= kSameCalloutMs);
      callouts += 1;
    }
    lastBegun.set(step.prompt.text, now);
    endsAt = now + 200 + random(3000);
  }
  assert.ok(callouts > 3, `${callouts}`);
});
