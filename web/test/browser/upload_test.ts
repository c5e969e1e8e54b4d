// Handing in what an app recorded.
import assert from 'node:assert/strict';
import { mkdtempSync, rmSync, writeFileSync } from 'node:fs';
import { tmpdir } from 'node:os';
import { join } from 'node:path';
import { after, test } from 'node:test';
import type { ElementHandle } from 'puppeteer-core';

import { tellJob } from '../stand_in_api';
import { closeBrowser, gets, kPhone, kWaiting, openVisit, skipReason, withServer, type Visit } from './harness';
import { goTo, heardOnce } from './person';

const folder = mkdtempSync(join(tmpdir(), 'roomwise-'));
after(async () => {
  rmSync(folder, { recursive: true });
  await closeBrowser();
});
const options = { skip: skipReason };

function exportOf(bytes: number): { path: string; content: Buffer } {
  const content = Buffer.from(Array.from({ length: bytes }, (_, i) => i % 251));
  const path = join(folder, `scan ${bytes}.zip`);
  writeFileSync(path, content);
  return { path, content };
}

async function choose(visit: Visit, path: string): Promise<void> {
  const input = await visit.page.evaluateHandle(() => [...document.querySelectorAll<HTMLInputElement>('input[type=file]')]
    .find((one) => one.labels?.[0]?.innerText === 'The exported file'));
  await (input as ElementHandle<HTMLInputElement>).uploadFile(path);
}

test('an export is handed in in pieces, over a busy computer, and mapped', options, () => withServer(async (server) => {
  const visit = await openVisit(server, { role: 'helper', size: kPhone });
  await visit.go('/');
  await goTo(visit, 'Walks', 'Walks');
  await visit.press('Hand in');
  await visit.sees('Choose the exported file first.', '[role=alert]');
  const { path, content } = exportOf(12_345);
  server.state.failsPieces = 2;
  await choose(visit, path);
  await visit.press('Hand in');
  await visit.hears('The connection is gone; it goes on as soon as it is back.');
  await heardOnce(visit, 'The file is there; the map is made now.');
  assert.ok(server.state.uploaded.equals(content));
  await visit.sees('Making the map', '.progress-words');
  tellJob(server, 'done', 1, '', 'map');
  await visit.hears('The map is made.');
  await visit.assertAccessible('handing in');
  await visit.assertReflows();
  await visit.close();
}));

test('what is there already is not sent again, and what waits can be mapped or removed', options, () => withServer(async (server) => {
  const { path, content } = exportOf(2500);
  server.state.uploads = [
    { upload: 'u1', name: 'scan 2500.zip', bytes: 2500, offset: 2000, chunk_bytes: 1000 },
    { upload: 'u2', name: 'old.zip', bytes: 10, offset: 10, chunk_bytes: 1000 },
    { upload: 'u3', name: 'flat.zip', bytes: 10, offset: 10, chunk_bytes: 1000, is_being_mapped: true },
  ];
  server.state.uploaded = Buffer.from(content.subarray(0, 2000));
  const visit = await openVisit(server, { role: 'helper' });
  await visit.go('/#walks');
  await visit.sees('scan 2500.zip: 80% is there');
  await visit.sees('old.zip is there and not mapped');
  await visit.sees('flat.zip is being mapped');
  const buttons = (name: string): Promise<number> => visit.page.$$eval('button:not([hidden])', (all, file) =>
    all.filter((one) => one.ariaLabel?.endsWith(` ${file}`)).length, name);
  assert.deepEqual([await buttons('old.zip'), await buttons('flat.zip')], [2, 0]);
  await visit.assertAccessible('what waits');
  await visit.sees('Connected', '.chip');
  tellJob(server, 'running', 0.1, 'mapping', 'map');
  await visit.sees('Making the map, 10%', '.progress-words');
  await visit.page.waitForNetworkIdle();
  const asked = (): number => visit.requests.filter((one) => one.endsWith('/api/uploads')).length;
  const before = asked();
  tellJob(server, 'running', 0.2, 'mapping', 'map');
  await visit.sees('Making the map, 20%', '.progress-words');
  await visit.page.waitForNetworkIdle();
  assert.equal(asked(), before, 'a job that goes on changes nothing here');
  await visit.press('Remove old.zip');
  await heardOnce(visit, 'old.zip is removed.');
  await choose(visit, path);
  await visit.press('Hand in');
  await visit.hears('The file is there; the map is made now.');
  assert.ok(server.state.uploaded.equals(content));
  await gets(() => server.state.requests.filter((one) => one.startsWith('PUT')).map((one) => one.split(' ')[1]), ['/api/uploads/u1/2000']);
  await visit.close();
}));

test('a file that the computer has no room for is refused beside its field', options, () => withServer(async (server) => {
  const visit = await openVisit(server, { role: 'helper' });
  await visit.go('/#walks');
  await visit.sees('Hand in what an app recorded');
  await choose(visit, exportOf(1_500_000).path);
  await visit.press('Hand in');
  await visit.sees("the computer's disk has room for 1 MB more", '[role=alert]');
  await visit.close();
}));

// The answer to a request whose path ends so waits until `release`.
interface Held {
  isHeld: boolean;
  release: () => void;
}

async function holdAnswer(visit: Visit, pathEnd: string): Promise<() => Promise<void>> {
  await visit.page.evaluate((end) => {
    const ask = window.fetch.bind(window);
    const held: Held = { isHeld: false, release: () => undefined };
    (window as unknown as { held: Held }).held = held;
    window.fetch = async (...asked) => {
      const answer = await ask(...asked);
      if (String(asked[0]).endsWith(end)) {
        await new Promise<void>((resolve) => Object.assign(held, { isHeld: true, release: resolve }));
      }
      return answer;
    };
  }, pathEnd);
  return async () => {
    await visit.page.waitForFunction(() => (window as unknown as { held: Held }).held.isHeld, kWaiting);
    await visit.page.evaluate(() => (window as unknown as { held: Held }).held.release());
  };
}

test('that a map cannot be made is the last thing that is said, though the answer comes after it', options, () => withServer(async (server) => {
  const visit = await openVisit(server, { role: 'helper' });
  await visit.go('/#walks');
  await visit.sees('Connected', '.chip');
  const release = await holdAnswer(visit, '/map');
  await choose(visit, exportOf(1500).path);
  await visit.press('Hand in');
  await visit.sees('Making the map', '.progress-words');
  tellJob(server, 'failed', 0, '', 'map');
  await visit.hears('The map could not be made.');
  await release();
  await visit.page.waitForFunction(() => [...document.querySelectorAll('button')].find((one) => one.textContent === 'Stop sending')?.hidden, kWaiting);
  assert.equal(await visit.page.$eval('.announcer', (one) => one.textContent), '');
  await visit.close();
}));

test('who stops sending goes on where it is handed in, and no share of it is told any more', options, () => withServer(async (server) => {
  const visit = await openVisit(server, { role: 'helper' });
  await visit.go('/#walks');
  await visit.sees('Hand in what an app recorded');
  const release = await holdAnswer(visit, '/0');
  await choose(visit, exportOf(12_345).path);
  await visit.press('Hand in');
  await visit.hears('0% of');
  await visit.press('Stop sending');
  await release();
  await visit.sees('Sending has stopped. Hand in the same file to go on.', '.progress-words');
  assert.equal(await visit.focused(), 'Hand in');
  const told = await visit.page.$$eval('[role=status]', (all) => all.map((one) => one.textContent).join());
  assert.doesNotMatch(told, /%/);
  await visit.close();
}));
