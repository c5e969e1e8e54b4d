import assert from 'node:assert/strict';
import { test } from 'node:test';

import type { RoomRange } from '../shared/protocol';
import { picturesOf, roomAt, spansOf, withRange, without } from './ranges';

const range = (first: number, last: number, room: string): RoomRange => ({ first, last, room });
const kWalk = [range(0, 9, 'corridor'), range(10, 19, 'kitchen'), range(30, 39, 'bedroom')];

test('a range goes where nothing was', () => {
  assert.deepEqual(withRange(kWalk, range(20, 29, 'bath')), [kWalk[0], kWalk[1], range(20, 29, 'bath'), kWalk[2]]);
});

test('a range takes its frames from the others: from an end, the middle, or all', () => {
  assert.deepEqual(withRange(kWalk, range(8, 12, 'bath')), [
    range(0, 7, 'corridor'), range(8, 12, 'bath'), range(13, 19, 'kitchen'), kWalk[2],
  ]);
  assert.deepEqual(withRange(kWalk, range(13, 15, 'bath')), [
    kWalk[0], range(10, 12, 'kitchen'), range(13, 15, 'bath'), range(16, 19, 'kitchen'), kWalk[2],
  ]);
  assert.deepEqual(withRange(kWalk, range(0, 99, 'hall')), [range(0, 99, 'hall')]);
});

test('neighbours of one room become one', () => {
  assert.deepEqual(withRange(kWalk, range(20, 25, 'kitchen')), [kWalk[0], range(10, 25, 'kitchen'), kWalk[2]]);
  assert.deepEqual(withRange(kWalk, range(10, 19, 'corridor')), [range(0, 19, 'corridor'), kWalk[2]]);
});

test('frames can be taken out', () => {
  assert.deepEqual(without(kWalk, 5, 31), [range(0, 4, 'corridor'), range(32, 39, 'bedroom')]);
  assert.deepEqual(without(kWalk, 10, 19), [kWalk[0], kWalk[2]]);
});

test('each frame has at most one room, whatever is put in', () => {
  let ranges: RoomRange[] = [];
  const truth: (string | null)[] = Array.from({ length: 50 }, () => null);
  for (let i = 0; i < 400; i += 1) {
    const first = (i * 37) % 50;
    const last = Math.min(49, first + ((i * 11) % 13));
    const room = ['a', 'b', 'c'][i % 3] as string;
    ranges = i % 5 === 4 ? without(ranges, first, last) : withRange(ranges, range(first, last, room));
    truth.fill(i % 5 === 4 ? null : room, first, last + 1);
    assert.deepEqual(Array.from({ length: 50 }, (_, frame) => roomAt(ranges, frame)), truth);
  }
});

const kKeyframes = [{ id: 7, frame: 12, time_s: 105 }, { id: 5, frame: 2, time_s: 100 }, { id: 6, frame: 9, time_s: 103.5 }];

test('key-frames share all frames of the walk among them', () => {
  assert.deepEqual(spansOf(kKeyframes, 20), [
    { keyframe: 5, first: 0, last: 8, time_s: 0 }, { keyframe: 6, first: 9, last: 11, time_s: 3.5 },
    { keyframe: 7, first: 12, last: 19, time_s: 5 },
  ]);
  assert.deepEqual(spansOf([], 20), []);
});

test('a range is told by the pictures that have frames of it', () => {
  const spans = spansOf(kKeyframes, 20);
  assert.deepEqual(picturesOf(spans, { first: 9, last: 19 }), [1, 2]);
  assert.deepEqual(picturesOf(spans, { first: 3, last: 10 }), [0, 1]);
  assert.equal(picturesOf(spans, { first: 20, last: 25 }), null);
  assert.equal(picturesOf([], { first: 0, last: 5 }), null);
});
