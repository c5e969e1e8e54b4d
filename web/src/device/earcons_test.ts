import assert from 'node:assert/strict';
import { test } from 'node:test';

import type { Sound } from '../shared/protocol';
import { lengthMs, notesOf, vibrationOf } from './earcons';

const kSounds: Sound[] = ['answer', 'unsure', 'lost', 'back', 'alert'];

// Up, down, or level, a note each: what tells sounds apart for ears that do not know pitches.
function contour(sound: Sound): string {
  const notes = notesOf(sound);
  return notes
    .map((note, i) => Math.sign(note.to - note.from) + ':' + Math.sign(note.from - (notes[i - 1]?.to ?? note.from)))
    .join(' ');
}

test('no two sounds have the same contour, nor the same vibration', () => {
  assert.equal(new Set(kSounds.map(contour)).size, kSounds.length);
  assert.equal(new Set(kSounds.map((sound) => vibrationOf(sound).join())).size, kSounds.length);
});

test('sounds are short, and silence has none', () => {
  for (const sound of kSounds) {
    assert.ok(lengthMs(sound) >= 100 && lengthMs(sound) <= 500, sound);
  }
  assert.equal(lengthMs('none'), 0);
});
