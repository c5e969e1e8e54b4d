// How somebody is led, on the helper's page, and on the phone what says who may see it.
import assert from 'node:assert/strict';
import { after, test } from 'node:test';

import { madeUpWalk } from '../made_up_home';
import { makePrompt, type StandInServer } from '../stand_in_server';
import { closeBrowser, gets, kDesktop, kPhone, kWaiting, openVisit, skipReason, until, withServer, type Visit } from './harness';
import { goTo, heardOnce } from './person';

after(closeBrowser);
const options = { skip: skipReason };

async function openLed(server: StandInServer, more: Parameters<typeof openVisit>[1] = {}): Promise<Visit> {
  const visit = await openVisit(server, { role: 'helper', ...more });
  await visit.go('/');
  await goTo(visit, 'Led now', 'Led now');
  await gets(() => server.newest('helper').told.at(-1), { type: 'watch', on: true });
  return visit;
}

for (const [size, dark, name] of [[kDesktop, false, 'desktop'], [kPhone, true, 'phone, dark'], [{ width: 320, height: 568 }, false, '320 px wide']] as const) {
  test(`a helper sees how somebody is led: ${name}`, options, () => withServer(async (server) => {
    const visit = await openLed(server, { size, dark });
    await visit.sees('Nobody is connected who could be led.');
    server.tell('helper', madeUpWalk(1000, { may_watch: false, walk: null }));
    await visit.sees("Anna's phone: walks are not shown to helpers.");
    await visit.assertAccessible('walks that are not shown');
    server.tell('helper', madeUpWalk(1100, { walk: null }));
    await visit.sees("Anna's phone: nobody is being led.");
    server.tell('helper', madeUpWalk(2000));
    await visit.sees('kitchen · to: bed · 6.4 m to go · on the way', '.led');
    assert.equal(await visit.page.$eval('.led svg', (one) => one.getAttribute('aria-label')), 'kitchen · to: bed · 6.4 m to go · on the way');
    assert.equal((await visit.page.$$('.led .way')).length, 1);
    assert.equal((await visit.page.$$('.led .person:not(.old)')).length, 1);
    const said = (): Promise<(string | null)[]> => visit.page.$$eval('.led-said p span', (all) => all.map((one) => one.textContent));
    assert.deepEqual(await said(), ['To the bed: about 6 metres.', 'Turn right, to the door.']);
    await visit.assertAccessible('a walk that is shown');
    await visit.assertReflows();
    server.tell('helper', madeUpWalk(1500, {}, { state: 'paused' }));
    await visit.sees('seen 2 s ago', '.led');
    assert.equal((await visit.page.$$('.led .person.old')).length, 1);
    await visit.sees('on the way', '.led [role=status]');
    await visit.close();
  }));
}

test('what the guide says is read only to who wants that; a lost position is said to everybody', options, () => withServer(async (server) => {
  const visit = await openLed(server);
  server.tell('helper', madeUpWalk(2000));
  await visit.sees('Turn right, to the door.', '.led-said');
  const live = (): Promise<string | null> => visit.page.$eval('.led-said', (one) => one.getAttribute('aria-live'));
  assert.equal(await live(), 'off');
  await visit.tabTo('Have a screen reader read what the guide says');
  await visit.page.keyboard.press('Space');
  assert.equal(await live(), 'polite');
  const { walk } = madeUpWalk(3000);
  server.tell('helper', madeUpWalk(3000, {}, { state: 'lost', said: [...(walk?.said ?? []), { t: 2900, text: 'Stop and wait.' }] }));
  await heardOnce(visit, 'Stop and wait.');
  await heardOnce(visit, 'position lost');
  assert.equal((await visit.page.$$('.led .person.old')).length, 1);
  server.tell('helper', madeUpWalk(3100, { device: 4, name: 'Chest camera' }));
  await visit.sees('Chest camera', '.led h4');
  assert.deepEqual(await visit.page.$$eval('.led-said', (all) => all.map((one) => one.getAttribute('aria-live'))), ['polite', 'polite']);
  server.tell('helper', madeUpWalk(3200, { may_watch: false, walk: null }));
  await visit.sees("Anna's phone: walks are not shown to helpers.");
  assert.equal((await visit.page.$$('.led')).length, 1, 'nothing of it stays');
  await visit.close();
}));

test('a page watches only while it shows that part', options, () => withServer(async (server) => {
  const visit = await openVisit(server, { role: 'helper' });
  await visit.go('/');
  await visit.sees('microwave', '.thing');
  await gets(() => server.newest('helper').told, []);
  await goTo(visit, 'Led now', 'Led now');
  await until(() => server.newest('helper').told.length === 1);
  server.tell('helper', madeUpWalk(2000));
  await visit.sees('to: bed');
  await goTo(visit, 'Walks', 'Walks');
  await gets(() => server.newest('helper').told, [{ type: 'watch', on: true }, { type: 'watch', on: false }]);
  await goTo(visit, 'Led now', 'Led now');
  await visit.sees('Nobody is connected who could be led.');
  await server.stop();
  await server.start();
  await gets(() => server.newest('helper').told, [{ type: 'watch', on: true }], 'of a computer that came back');
  await visit.close();
}));

test('who is led lets helpers watch, and ends it by a button, by a word, or in the settings', options, () => withServer(async (server) => {
  const visit = await openVisit(server, { role: 'device', size: kPhone });
  await visit.go('/device');
  await visit.sees('Who shall speak?');
  await visit.press('Start');
  await visit.sees('Connected', '.chip');
  assert.equal(server.newest('device').hello?.may_watch, false);
  const box = 'Helpers may see where I am, and watch when I am led';
  const toggle = async (): Promise<void> => {
    await visit.press('Settings');
    await visit.tabTo(box);
    await visit.page.keyboard.press('Space');
    await visit.page.keyboard.press('Escape');
  };
  const settled = (): unknown => server.newest('device').told.at(-1)?.['may_watch'];
  const stored = (): Promise<boolean> => visit.page.evaluate(() =>
    (JSON.parse(localStorage.getItem('roomwise.settings') ?? '{}') as { mayWatch: boolean }).mayWatch);
  await toggle();
  await gets(settled, true);
  await visit.press('Take me…');
  await visit.press('bed');
  await visit.sees('Turn right', '[role=log]');
  await visit.assertAccessible('a walk that helpers may watch');
  await visit.press('Stop showing');
  await visit.sees('Nobody watches your walks.', '[role=log]');
  assert.equal(server.newest('device').asked.at(-1)?.['question'], 'hide_walks');
  assert.equal(await stored(), false);
  assert.equal(await visit.page.$eval('.hide', (one) => (one as HTMLElement).hidden), true);
  assert.equal(await visit.focused(), 'What next', 'the focus stays on the way');
  await toggle();
  await gets(settled, true);
  server.tell('device', makePrompt({ key: 'watch', message: 'watch.hidden', text: 'Nobody watches your walks.' }));
  await visit.page.waitForFunction(() => !(JSON.parse(localStorage.getItem('roomwise.settings') ?? '{}') as { mayWatch: boolean }).mayWatch, kWaiting);
  await server.stop();
  await server.start();
  await until(() => server.newest('device').hello?.may_watch === false);
  await visit.close();
}));
