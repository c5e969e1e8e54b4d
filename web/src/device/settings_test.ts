import assert from 'node:assert/strict';
import { test } from 'node:test';

import { kDefaults, settingsFrom } from './settings';

test('what was stored comes back', () => {
  const settings = { ...kDefaults, voice: 'reader' as const, rate: 2, distances: 'steps' as const, callouts: false, aim: false, mayWatch: true };
  assert.deepEqual(settingsFrom(JSON.stringify(settings)), settings);
});

test('what is missing or wrong is taken from the defaults, the rest is kept', () => {
  for (const stored of [null, '', '{', 'null', '7', '[]']) {
    assert.deepEqual(settingsFrom(stored), kDefaults, String(stored));
  }
  const mixed = settingsFrom('{"voice": "loud", "rate": 99, "step_m": "0.5", "sounds": false}');
  assert.deepEqual(mixed, { ...kDefaults, sounds: false });
});
