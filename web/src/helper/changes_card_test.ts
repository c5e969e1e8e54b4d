import assert from 'node:assert/strict';
import { test } from 'node:test';

import { makeHome } from '../../test/made_up_home';
import { changeWords, sinceWords } from './changes_card';

test('a change is told with its room and how far the thing was moved', () => {
  assert.equal(changeWords({ what: 'moved', name: 'chair', room: 'kitchen', moved_m: 1.24 }), 'chair: moved by 1.2 m (kitchen)');
  assert.equal(changeWords({ what: 'gone', name: 'vase', room: null, moved_m: null }), 'vase: gone');
});

test('the walks are told by their names, also where nothing changed', () => {
  const home = makeHome();
  home.recordings.push({ ...home.recordings[0]!, id: 2, name: 'evening' });
  home.changes = { walk: 2, since: 1, things: [] };
  assert.match(sinceWords(home), /evening found all things where the walk walk had seen them/);
  home.changes.things.push({ what: 'new', name: 'cup', room: null, moved_m: null });
  assert.equal(sinceWords(home), 'The walk evening found this other than the walk walk:');
});
