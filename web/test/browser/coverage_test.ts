// What the walks have not shown yet, on the helper's page.
import assert from 'node:assert/strict';
import { after, test } from 'node:test';

import { tellJob } from '../stand_in_api';
import { closeBrowser, kDesktop, kPhone, openVisit, skipReason, withServer } from './harness';

after(closeBrowser);
const options = { skip: skipReason };

for (const [size, name] of [[kDesktop, 'desktop'], [kPhone, 'phone'], [{ width: 320, height: 568 }, '320 px wide']] as const) {
  test(`what is missing stands in sentences, with its numbers on the plan: ${name}`, options, () => withServer(async (server) => {
    const visit = await openVisit(server, { role: 'helper', size });
    await visit.go('/#walks');
    await visit.sees('6 pictures of the walk walk belong to no room.', '.coverage');
    await visit.sees('Say above in which room they were taken.', '.coverage');
    await visit.sees('3a The floor goes on where no walk saw it: by the refrigerator, over 0.9 m.', '.coverage');
    assert.deepEqual(await visit.page.$$eval('.looked-at .gap', (all) => all.map((one) => one.textContent)), ['1', '2', '2a', '3', '3a']);
    const label = await visit.page.$eval('.looked-at svg', (one) => one.getAttribute('aria-label'));
    assert.equal(label, 'Plan of the home from above, with the numbers of this list: 1 bathroom, 2 bedroom, 3 kitchen.');
    assert.ok((await visit.accessibleTexts()).includes('3 kitchen'));
    await visit.assertAccessible('what is missing');
    await visit.assertReflows();
    await visit.close();
  }));
}

test('while the map is made it is told when; then it comes by itself', options, () => withServer(async (server) => {
  const ready = server.state.coverage;
  server.state.coverage = null;
  const visit = await openVisit(server, { role: 'helper' });
  await visit.go('/#walks');
  await visit.sees('It is told in a moment, or when the map is ready.');
  server.state.coverage = ready;
  tellJob(server, 'done', 1, '', 'prepare');
  await visit.sees('It was seen by day only', '.coverage');
  await visit.close();
}));

test('while it is worked out for another page it is asked for again', options, () => withServer(async (server) => {
  const ready = server.state.coverage;
  server.state.coverage = null;
  const visit = await openVisit(server, { role: 'helper' });
  await visit.go('/#walks');
  await visit.sees('It is told in a moment, or when the map is ready.');
  server.state.coverage = ready;
  await visit.sees('It was seen by day only', '.coverage');
  await visit.close();
}));

test('where nothing is missing, that is told; an empty home has no such list', options, () => withServer(async (server) => {
  server.state.coverage = { missing: [], rooms: [], floor_known: true };
  const visit = await openVisit(server, { role: 'helper' });
  await visit.go('/#walks');
  await visit.sees('Nothing is missing.');
  server.state.home.recordings = [];
  await visit.page.reload();
  await visit.sees('Record a walk', 'h3');
  assert.ok(!(await visit.accessibleTexts()).includes('What is still missing'));
  await visit.close();
}));
