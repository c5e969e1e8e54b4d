// Asking a question as the person would, on the helper's page.
import assert from 'node:assert/strict';
import { after, test } from 'node:test';

import { closeBrowser, gets, kDesktop, kPhone, openVisit, skipReason, withServer } from './harness';
import { kSaidAlong } from '../stand_in_api';
import { heardOnce } from './person';

after(closeBrowser);
const options = { skip: skipReason };

for (const [size, name] of [[kDesktop, 'desktop'], [kPhone, 'phone'], [{ width: 320, height: 568 }, '320 px wide']] as const) {
  test(`a question is asked from a place on the plan, by keyboard alone: ${name}`, options, () => withServer(async (server) => {
    const visit = await openVisit(server, { role: 'helper', size });
    await visit.go('/#recognise');
    await visit.tabTo('Question');
    await visit.page.keyboard.press('Enter');
    await heardOnce(visit, 'Type a question first.');
    await visit.type('Take me to the microwave');
    const picker = await visit.page.waitForSelector('.picker');
    await picker?.focus();
    for (const key of ['Enter', 'ArrowUp', 'Enter'] as const) {
      await visit.page.keyboard.press(key);
    }
    await visit.press('Ask');
    await heardOnce(visit, 'To the microwave: about 6 metres. Turn left.');
    assert.deepEqual(await visit.page.$$eval('.along li', (all) => all.map((one) => one.textContent)), kSaidAlong);
    await visit.sees('The way that they would be led: 6.2 m, through bathroom, corridor, kitchen.');
    const label = await visit.page.$eval('.looked-at svg', (one) => one.getAttribute('aria-label'));
    assert.equal(label, 'The way that they would be led: 6.2 m, through bathroom, corridor, kitchen.');
    assert.equal((await visit.page.$$('.way')).length, 1);
    const asked = JSON.parse((server.state.requests.at(-1) ?? '').replace('POST /api/ask ', '')) as Record<string, unknown>;
    assert.equal(asked['language'], 'en');
    assert.equal(Math.round(asked['heading_degrees'] as number), 90);
    await visit.assertAccessible('a question that is tried');
    await visit.assertReflows();
    await visit.close();
  }));
}

test('without a place it is said why no way is shown; points can be set anew', options, () => withServer(async (server) => {
  const visit = await openVisit(server, { role: 'helper' });
  await visit.go('/#recognise');
  await visit.tabTo('Question');
  await visit.type('Where am I?');
  await visit.page.keyboard.press('Enter');
  await heardOnce(visit, 'I do not know this place.');
  await visit.sees('set where the person stands');
  await gets(() => server.state.requests, ['POST /api/ask {"text":"Where am I?","language":"en"}']);
  const picker = await visit.page.waitForSelector('.picker');
  await picker?.focus();
  await visit.page.keyboard.press('Enter');
  assert.equal((await visit.page.$$('.picker .drawing circle')).length, 1);
  await visit.press('Set the points anew');
  assert.equal((await visit.page.$$('.picker .drawing circle')).length, 0);
  await visit.close();
}));
