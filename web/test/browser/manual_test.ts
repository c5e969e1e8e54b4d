import assert from 'node:assert/strict';
import { after, test } from 'node:test';

import { closeBrowser, kDesktop, kPhone, openVisit, skipReason, withServer } from './harness';

after(closeBrowser);
const options = { skip: skipReason };

test("the helper's page leads to the manual, and its links lead on", options, () => withServer(async (server) => {
  const visit = await openVisit(server, { role: 'helper' });
  await visit.go('/');
  await visit.tabTo('Help');
  await visit.page.keyboard.press('Enter');
  await visit.sees('The manual of Roomwise', 'h1');
  await visit.tabTo('Skip to the content');
  await visit.tabTo('The first home');
  await visit.page.keyboard.press('Enter');
  await visit.sees('From an empty home to the first answer.', 'main');
  assert.equal(await visit.page.$eval('nav [aria-current=page]', (link) => link.textContent), 'The first home');
  await visit.close();
}));

test("a phone's settings lead to the card in its language, with its recording", options, () => withServer(async (server) => {
  const visit = await openVisit(server, { role: 'device', size: kPhone });
  await visit.go('/device');
  await visit.press('Start');
  await visit.sees('Connected', '.chip');
  await visit.page.click('.tools button:last-child');
  await visit.tabTo('How to use this');
  const address = await visit.page.evaluate(() => (document.activeElement as HTMLAnchorElement).href);
  await visit.go(new URL(address).pathname);
  await visit.sees('Asking your home', 'h1');
  const recording = await visit.page.evaluate(async () => {
    const answer = await fetch((document.querySelector('audio') as HTMLAudioElement).src);
    return `${answer.status} ${(await answer.arrayBuffer()).byteLength > 100_000}`;
  });
  assert.equal(recording, '200 true');
  await visit.close();
}));

for (const [name, size, dark] of [['small', kPhone, false], ['large', kDesktop, true]] as const) {
  test(`axe-core finds nothing in the manual: ${name}`, options, () => withServer(async (server) => {
    const visit = await openVisit(server, { size, dark });
    await visit.go('/help/index.html');
    const chapters = await visit.page.$$eval('main a', (links) => links.map((link) => new URL((link as HTMLAnchorElement).href).pathname));
    assert.ok(chapters.length > 15);
    for (const path of ['/help/index.html', ...chapters]) {
      await visit.go(path);
      await visit.assertAccessible(path);
      await visit.assertReflows();
    }
    await visit.close();
  }));
}
