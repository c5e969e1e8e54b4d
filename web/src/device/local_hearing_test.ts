import assert from 'node:assert/strict';
import { afterEach, test } from 'node:test';

import { localHearing, tagOf } from './local_hearing';

const world = globalThis as { SpeechRecognition?: unknown; webkitSpeechRecognition?: unknown };

function recogniser(state: string | Error, isLocal = true): unknown {
  const kind = Object.assign(function recognition() { /* never begun */ }, {
    available: async () => {
      if (state instanceof Error) {
        throw state;
      }
      return state;
    },
  });
  kind.prototype = isLocal ? { processLocally: false } : {};
  return kind;
}

afterEach(() => {
  delete world.SpeechRecognition;
  delete world.webkitSpeechRecognition;
});

test('speech is understood only where that happens on the phone itself', async () => {
  const hears = async (): Promise<boolean> => (await localHearing('en', [])) !== null;
  assert.equal(await hears(), false, 'no recogniser');
  world.webkitSpeechRecognition = function older() { /* says nothing of where it works */ };
  assert.equal(await hears(), false);
  world.SpeechRecognition = recogniser('available', false);
  assert.equal(await hears(), false, 'it cannot be kept on the phone');
  for (const state of ['downloadable', 'downloading', 'unavailable']) {
    world.SpeechRecognition = recogniser(state);
    assert.equal(await hears(), false, state);
  }
  world.SpeechRecognition = recogniser(new Error('not allowed here'));
  assert.equal(await hears(), false);
  world.SpeechRecognition = recogniser('available');
  assert.equal(await hears(), true);
});

test('a recogniser is asked for the region that somebody prefers', () => {
  assert.equal(tagOf('de', ['en-GB', 'de-AT', 'de-DE']), 'de-AT');
  assert.equal(tagOf('de', ['en-GB', 'de']), 'de-DE');
  assert.equal(tagOf('xx', []), 'xx');
});
