// The helper's own hand: the plan, changes on it and in the list beside it, and taking them back.
import assert from 'node:assert/strict';
import { after, test } from 'node:test';

import { closeBrowser, gets, kDesktop, kPhone, openVisit, skipReason, withServer } from './harness';
import { heardOnce, retype } from './person';

after(closeBrowser);
const options = { skip: skipReason };

test('the plan shows rooms, doors and things, with a legend, and says so in words', options, () => withServer(async (server) => {
  const visit = await openVisit(server, { role: 'helper', size: kDesktop });
  await visit.go('/');
  await visit.sees('kitchen, 9.6 m²', '.legend');
  await visit.sees('Door', '.legend');
  const names = await visit.page.$$eval('.plan .room-name', (all) => all.map((one) => one.textContent));
  assert.deepEqual(names, ['corridor', 'kitchen', 'bathroom', 'bedroom']);
  const label = await visit.page.$eval('svg.plan[role=img]', (one) => one.getAttribute('aria-label'));
  assert.equal(label, 'Plan of the home from above: 4 rooms, 10 things. The same is told, and can be changed, in the list beside it.');
  await visit.assertAccessible('the plan');
  await visit.close();
}));

test('of several storeys one is shown at a time, chosen by keyboard, and the stairs are told in words', options, () => withServer(async (server) => {
  server.state.home = {
    ...server.state.home,
    storeys: [{ from_x: null, plan_from_level: [0, 0], floor_m: 0 }, { from_x: 4.9, plan_from_level: [20, 0], floor_m: 2.8 }],
    stairs: [{ rooms: ['corridor', 'bedroom'], storeys: [0, 1], steps: 14, left_rail: false, right_rail: true }],
  };
  const visit = await openVisit(server, { role: 'helper', size: kDesktop });
  await visit.go('/');
  await visit.sees('Stairs from corridor up to bedroom, 14 steps, rail on the right', '.legend');
  const names = (): Promise<(string | null)[]> => visit.page.$$eval('.plan .room-name', (all) => all.map((one) => one.textContent));
  assert.deepEqual(await names(), ['corridor', 'kitchen', 'bathroom']);
  await visit.tabTo('Storey 1: corridor, kitchen, bathroom');
  await visit.page.keyboard.press('ArrowDown');
  assert.deepEqual(await names(), ['bedroom']);
  assert.equal(await visit.focused(), 'Storey 2: bedroom');
  await visit.assertAccessible('the plan of a storey');
  await visit.close();
}));

test('renaming a thing is undone by one button that says what it takes back', options, () => withServer(async (server) => {
  const visit = await openVisit(server, { role: 'helper' });
  await visit.go('/');
  await visit.press('Correct microwave');
  await retype(visit, 'oven');
  await visit.page.keyboard.press('Enter');
  await heardOnce(visit, 'It is called oven now.');
  await visit.press('Undo: renamed microwave to oven');
  await heardOnce(visit, 'Undone: renamed microwave to oven.');
  assert.equal(await visit.focused(), 'The home', 'there is nothing more to undo');
  await visit.sees('microwave', '.thing');
  await gets(() => server.state.requests, ['PUT /api/things/0 {"name":"oven"}', 'DELETE /api/edits/1']);
  await visit.close();
}));

test('a note and a double, by keyboard alone', options, () => withServer(async (server) => {
  const visit = await openVisit(server, { role: 'helper' });
  await visit.go('/');
  await visit.press('More stove');
  await visit.press('Note');
  await visit.type('hot');
  await visit.page.keyboard.press('Enter');
  await heardOnce(visit, 'The note on the stove is saved.');
  await visit.sees('hot', '.note');
  await visit.press('More stove');
  await visit.press('It is listed twice');
  await visit.press('Merge');
  await heardOnce(visit, 'The stove and its double are one now.');
  await visit.sees('Undo: merged stove with dining table');
  await visit.close();
}));

test('a thing is added at a place that arrow keys choose on the plan', options, () => withServer(async (server) => {
  const visit = await openVisit(server, { role: 'helper' });
  await visit.go('/');
  await visit.press('Add a thing');
  await visit.type('kettle');
  await visit.tabTo('Or set its place on the plan. Tap the plan; or arrow keys move the cross, with Shift in larger steps; Enter sets a point; Backspace takes the last one away.');
  await visit.page.keyboard.down('Shift');
  await visit.page.keyboard.press('ArrowLeft');
  await visit.page.keyboard.up('Shift');
  await visit.page.keyboard.press('ArrowUp');
  await visit.hears('bathroom; 4.2 m from the left, 2.9 m from below');
  await visit.page.keyboard.press('Enter');
  await visit.hears('Point 1 is set');
  await visit.assertAccessible('the plan');
  await visit.press('Add');
  await heardOnce(visit, 'Added: kettle.');
  await visit.sees('kettle', '.thing');
  const asked = JSON.parse((server.state.requests.at(-1) ?? '').replace('POST /api/edits ', '')) as { position: number[] };
  assert.deepEqual(asked.position.map((one) => Math.round(one * 10) / 10), [3.8, 2.5]);
  await visit.close();
}));

test('a room is divided by a line; without one it is said what is missing', options, () => withServer(async (server) => {
  const visit = await openVisit(server, { role: 'helper', size: kPhone });
  await visit.go('/');
  await visit.press('More kitchen');
  await visit.press('Divide');
  await visit.type('pantry');
  await visit.page.keyboard.press('Enter');
  await heardOnce(visit, 'Set three points on the plan first');
  const picker = await visit.page.waitForSelector('.picker');
  await picker?.focus();
  for (const key of ['Enter', 'ArrowRight', 'Enter', 'ArrowUp', 'Enter'] as const) {
    await visit.page.keyboard.press(key);
  }
  await visit.assertAccessible('the plan');
  await visit.press('Divide');
  await heardOnce(visit, 'pantry is a room beside kitchen now.');
  const asked = JSON.parse((server.state.requests.at(-1) ?? '').replace('POST /api/edits ', '')) as { line: number[][] };
  assert.deepEqual(asked.line.map(([x, y]) => [Math.round((x ?? 0) * 10) / 10, Math.round((y ?? 0) * 10) / 10]), [[1.5, 3.1], [1.6, 3.1]]);
  await visit.close();
}));

test('what another helper changed meanwhile is told, and the list is fresh', options, () => withServer(async (server) => {
  const visit = await openVisit(server, { role: 'helper' });
  await visit.go('/');
  await visit.press('Correct microwave');
  await retype(visit, 'oven');
  await visit.page.keyboard.press('Enter');
  await heardOnce(visit, 'It is called oven now.');
  await visit.sees('Undo: renamed microwave to oven');
  server.state.edits.push({ ...(server.state.edits[0] as (typeof server.state.edits)[0]), edit: 2, name: 'grill', undo: () => undefined });
  await visit.press('Undo: renamed microwave to oven');
  await heardOnce(visit, 'something later is about the same');
  await visit.sees('Undo: renamed microwave to grill');
  await visit.close();
}));

test('a device is called otherwise', options, () => withServer(async (server) => {
  const visit = await openVisit(server, { role: 'helper' });
  await visit.go('/#devices');
  await visit.press('Rename Chest camera');
  await retype(visit, 'Belt');
  await visit.page.keyboard.press('Enter');
  await heardOnce(visit, 'It is called Belt now.');
  await visit.sees('Belt', '.device-name');
  await gets(() => server.state.requests, ['PUT /api/devices/4 {"name":"Belt"}']);
  await visit.close();
}));

test('the first steps tell what is done and lead to what comes next', options, () => withServer(async (server) => {
  server.state.home.learned = null;
  server.state.recognitions = [];
  const visit = await openVisit(server, { role: 'helper' });
  await visit.go('/');
  await visit.sees('Let the rooms be learned. next', '.steps');
  await visit.sees('Name the rooms of the walk. done', '.steps');
  await visit.assertAccessible('the first steps');
  await visit.press('Let the rooms be learned.');
  await visit.sees('Recognise', 'h2');
  await visit.close();
}));
