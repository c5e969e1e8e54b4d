import assert from 'node:assert/strict';
import { test } from 'node:test';

import { makeHome } from '../../test/made_up_home';
import { firstSteps } from './first_steps';

const left = (steps: ReturnType<typeof firstSteps>): string[] => steps.filter(({ done }) => !done).map(({ key }) => key);

test('an empty home has all steps before it', () => {
  const home = { ...makeHome(), learned: null, recordings: [] };
  assert.deepEqual(left(firstSteps({ devices: [], home, recognitions: [] })), ['pair', 'record', 'name', 'learn', 'try']);
});

test('what is done is told by the home itself', () => {
  const home = { ...makeHome(), learned: null };
  const devices = [{ device: 3, name: 'phone', role: 'device' as const, paired: 1, last_seen: 1, online: false }];
  assert.deepEqual(left(firstSteps({ devices, home, recognitions: [] })), ['learn', 'try']);
  assert.deepEqual(left(firstSteps({ devices, home: makeHome(), recognitions: [] })), ['try']);
});

test('rooms learned from photos need no walk', () => {
  const home = { ...makeHome(), recordings: [] };
  assert.deepEqual(left(firstSteps({ devices: [], home, recognitions: [] })), ['pair', 'try']);
});
