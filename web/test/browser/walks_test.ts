// Walks: listed, gone on with, forgotten with a way back, erased.
import assert from 'node:assert/strict';
import { after, test } from 'node:test';

import { tellJob } from '../stand_in_api';
import { closeBrowser, gets, kDesktop, kPhone, openVisit, skipReason, withServer } from './harness';
import { goTo, heardOnce, pressWhile } from './person';

after(closeBrowser);
const options = { skip: skipReason };

for (const [size, name] of [[kDesktop, 'desktop'], [kPhone, 'phone'], [{ width: 320, height: 568 }, '320 px wide']] as const) {
  test(`a walk is forgotten, taken back, forgotten again and erased: ${name}`, options, () => withServer(async (server) => {
    const visit = await openVisit(server, { role: 'helper', size });
    await visit.go('/#walks');
    await visit.sees('recorded May 3, 2026, 12:30 PM · 96 pictures', '.walks');
    await visit.assertAccessible('the walks');
    await visit.assertReflows();
    await visit.press('Forget walk');
    await visit.sees('Forget the walk walk?', 'dialog');
    await visit.press('Forget');
    await heardOnce(visit, 'The walk walk is forgotten. It can be taken back until it is erased.');
    await visit.sees('There is no walk yet.');
    await goTo(visit, 'Forget', 'Forget');
    await visit.sees("It goes for good at once if you say so, else when the home's computer is switched off");
    await visit.assertAccessible('what is erased soon');
    await visit.assertReflows();
    await visit.press('Take back: The walk walk');
    await heardOnce(visit, 'The walk walk is back.');
    assert.equal(await visit.focused(), 'Forget', 'nothing more is to be erased');
    await visit.press('Forget a walk');
    await visit.sees('The walk walk', '.ranges');
    await visit.press('Erase now');
    await visit.sees('It cannot be taken back.', 'dialog');
    await visit.press('Erase now');
    await heardOnce(visit, 'It is erased.');
    await gets(() => server.state.requests, [
      'POST /api/edits {"what":"take walk away","walk":1}', 'DELETE /api/edits/1', 'POST /api/edits {"what":"take walk away","walk":1}', 'POST /api/erase',
    ]);
    assert.ok(!(await visit.accessibleTexts()).includes('What is erased soon'));
    await visit.close();
  }));
}

test('erasing that failed is told as long as it is owed', options, () => withServer(async (server) => {
  server.state.home.to_erase.owed = true;
  const visit = await openVisit(server, { role: 'helper' });
  await visit.go('/#forget');
  await visit.sees('is not erased from the file yet');
  await visit.assertAccessible('erasing that is owed');
  await visit.close();
}));

test('a map that was stopped is gone on with by a button', options, () => withServer(async (server) => {
  const visit = await openVisit(server, { role: 'helper' });
  await visit.go('/#walks');
  await visit.sees('96 pictures', '.walks');
  assert.ok(!(await visit.accessibleTexts()).includes('Go on with the map'));
  tellJob(server, 'failed', 0, '', 'map');
  await visit.hears('The map could not be made.');
  await visit.page.waitForNetworkIdle();
  assert.ok(!(await visit.accessibleTexts()).includes('Go on with the map'), 'no walk waits');
  server.state.home.walk_waits = true;
  tellJob(server, 'stopped', 0.4, 'stopped', 'map');
  await visit.press('Go on with the map');
  await heardOnce(visit, 'The map is gone on with.');
  await gets(() => server.state.requests, ['POST /api/job/go_on']);
  await visit.close();
}));

test('a press on a walk while a map is made is not lost', options, () => withServer(async (server) => {
  const visit = await openVisit(server, { role: 'helper' });
  await visit.go('/#walks');
  await visit.sees('96 pictures', '.walks');
  await visit.sees('Connected', '.chip');
  await pressWhile(visit, 'Forget walk', async () => {
    tellJob(server, 'running', 0.4, 'mapping', 'map');
    await visit.sees('Making the map, 40%', '.progress-words');
  });
  await visit.sees('Forget the walk walk?', 'dialog');
  await visit.close();
}));

test('while a map is made names wait for their pictures, and the plan for the map', options, () => withServer(async (server) => {
  const { keyframes } = server.state;
  const { rooms } = server.state.plan;
  server.state.keyframes = [];
  server.state.plan.rooms = [];
  const visit = await openVisit(server, { role: 'helper' });
  await visit.go('/#walks');
  await visit.sees('Pictures that are not on the map: kitchen', '.ranges');
  tellJob(server, 'running', 0.3, 'mapping', 'map');
  await visit.sees('kitchen: the pictures appear once the map is ready.', '.ranges');
  assert.equal(await visit.page.$eval('.naming .ranges', (list) => list.querySelectorAll('button').length), 0);
  await visit.assertAccessible('names that wait');
  await visit.page.click('a[href="#home"]');
  await visit.sees('There is no plan yet: it appears once the map is ready.');
  tellJob(server, 'stopped', 0.3, 'stopped');
  await visit.sees('The map is being made ready; it will be shown here.', '.stage-note');
  server.state.keyframes = keyframes;
  server.state.plan.rooms = rooms;
  tellJob(server, 'done', 1, '', 'prepare');
  await visit.page.waitForSelector('.plan-part svg');
  await visit.sees('Drag to turn', '.stage-note');
  await visit.page.click('a[href="#walks"]');
  await visit.sees('Pictures 1 to', '.ranges');
  await visit.close();
}));
