import assert from 'node:assert/strict';
import { test } from 'node:test';

import { messages } from '../../../roomwise/guide/messages/en.json';
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

// Short, middling or long, a letter each: what a hand can tell.
const rhythm = (vibration: readonly number[]): string =>
  vibration.filter((_, i) => i % 2 === 0).map((ms) => (ms < 100 ? 's' : ms < 200 ? 'm' : 'l')).join('');

test('no two sounds have the same contour', () => {
  assert.equal(new Set(kSounds.map(contour)).size, kSounds.length);
});

test('left, right, stop and arrival feel different from each other and from every sound', () => {
  const feels = (message: string, sound: Sound = 'none'): string => {
    assert.ok(message in messages, message);
    return rhythm(vibrationOf({ sound, message }));
  };
  const told = ['guide.turn_left', 'guide.turn_right', 'guide.stop', 'guide.there_ahead'].map((message) => feels(message));
  assert.deepEqual(told, ['ls', 'sl', 'll', 'sssl']);
  const sounds = kSounds.map((sound) => feels('room.is', sound));
  assert.equal(new Set([...told, ...sounds]).size, told.length + kSounds.length, sounds.join());
  for (const [like, messages] of Object.entries({
    'guide.turn_left': ['guide.turn_hour_left', 'guide.little_left', 'guide.try_left'],
    'guide.turn_right': ['guide.turn_hour_right', 'guide.little_right', 'guide.try_right'],
    'guide.stop': [
      'guide.stop_obstacle_ahead', 'guide.stop_thing_left', 'guide.stop_door', 'guide.off', 'guide.lost', 'guide.lost_wait',
      'device.connection_lost_led',
    ],
    'guide.there_ahead': ['guide.there_left', 'guide.there_here', 'guide.there_room'],
  })) {
    messages.forEach((message) => assert.equal(feels(message, 'alert'), feels(like), message));
  }
  assert.equal(feels('guide.soon_left'), '', 'it is not yet time to turn');
  assert.equal(feels('guide.there_unseen'), '', 'perhaps it is something else');
});

test('sounds are short, and silence has none', () => {
  for (const sound of kSounds) {
    assert.ok(lengthMs(sound) >= 100 && lengthMs(sound) <= 500, sound);
  }
  assert.equal(lengthMs('none'), 0);
});
