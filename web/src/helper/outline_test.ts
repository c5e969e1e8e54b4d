import assert from 'node:assert/strict';
import { test } from 'node:test';

import { makeHome } from '../../test/made_up_home';
import { countOf, outlineOf } from './outline';

test('rooms come with their things and neighbours, by name', () => {
  const outline = outlineOf(makeHome());
  assert.deepEqual(outline.rooms.map(({ room }) => room.name), ['bathroom', 'bedroom', 'corridor', 'kitchen']);
  const kitchen = outline.rooms[3];
  assert.deepEqual(kitchen?.things.map((thing) => thing.name), ['dining table', 'microwave', 'refrigerator', 'stove']);
  assert.deepEqual(kitchen?.neighbours, ['corridor']);
  assert.deepEqual(outline.rooms[2]?.things.map(({ name, position }) => [name, position]), [['shelf', null]], 'without a place');
  assert.deepEqual(outline.rooms[2]?.neighbours, ['bathroom', 'bedroom', 'kitchen']);
  assert.deepEqual(countOf(outline), { rooms: 4, things: 10 });
});

test('a search keeps a fitting room whole, and of the others what fits', () => {
  const bed = outlineOf(makeHome(), 'BED');
  assert.deepEqual(bed.rooms.map(({ room, things }) => [room.name, things.length]), [['bedroom', 3]]);
  const wave = outlineOf(makeHome(), 'wave');
  assert.deepEqual(wave.rooms.map(({ room, things }) => [room.name, things.map((thing) => thing.name)]), [['kitchen', ['microwave']]]);
  assert.deepEqual(outlineOf(makeHome(), 'corridor').doorways.length, 3);
  assert.deepEqual(countOf(outlineOf(makeHome(), 'piano')), { rooms: 0, things: 0 });
});

test('things of no room, or of one that is gone, are not lost', () => {
  const home = makeHome();
  home.rooms = home.rooms.filter((room) => room.name !== 'bathroom');
  (home.things[0] as { room: string | null }).room = null;
  assert.deepEqual(outlineOf(home).elsewhere.map((thing) => thing.name), ['microwave', 'toilet', 'washbasin']);
});
