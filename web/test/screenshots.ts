// Pictures of every page, small and large, light and dark: npm run screenshots -- FOLDER.
import { mkdirSync, writeFileSync } from 'node:fs';
import { join } from 'node:path';

import { closeBrowser, kDesktop, kPhone, openVisit, withServer, type Visit } from './browser/harness';
import { drawnRoom } from './drawn_picture';
import { madeUpWalk } from './made_up_home';
import { tellJob, tellRecording } from './stand_in_api';
import type { StandInServer } from './stand_in_server';

const folder = process.argv[2] ?? 'screenshots';
mkdirSync(folder, { recursive: true });

async function phone(visit: Visit, shoot: (name: string) => Promise<void>, server: StandInServer): Promise<void> {
  await visit.go('/pair');
  await visit.sees('Pair this device');
  await visit.page.keyboard.press('Enter');
  await shoot('pair');
  await visit.go('/device');
  await visit.sees('Who shall speak?');
  await shoot('start');
  await visit.press('Start');
  await visit.sees('Connected', '.chip');
  await visit.press('What is around me');
  await visit.sees('Before you', '[role=log]');
  await visit.press('Where am I');
  await visit.sees('You are in the kitchen.', '[role=log]');
  await shoot('phone');
  await visit.press('Find…');
  await shoot('find');
  await visit.page.keyboard.press('Escape');
  await visit.page.click('.tools button:last-child');
  await shoot('settings');
  await visit.page.keyboard.press('Escape');
  await server.stop();
  await visit.sees('Not connected', '.chip');
  await shoot('lost');
  await server.start();
}

async function helper(visit: Visit, shoot: (name: string) => Promise<void>, server: StandInServer): Promise<void> {
  await visit.go('/');
  await visit.sees('microwave', '.thing');
  await visit.page.waitForSelector('.stage canvas');
  server.tell('helper', {
    type: 'device', device: 3, name: "Anna's phone", online: true,
    seen: { t: 1, verdict: 'room', room: 'kitchen', probability: 0.97, why: '', position: { x: 1.6, y: 3.4, z: 1.3, heading_degrees: 60, sigma_m: 0.05 } },
  });
  await visit.page.waitForSelector('.device-label');
  await visit.page.evaluate(() => new Promise((resolve) => requestAnimationFrame(() => requestAnimationFrame(resolve))));
  await shoot('home');
  await visit.page.click('[data-key="picture 0"]');
  await visit.page.waitForSelector('.boxed svg');
  await shoot('thing');
  await visit.page.keyboard.press('Escape');
  await visit.page.click('[data-key="edit kitchen"]');
  await shoot('room');
  await visit.page.keyboard.press('Escape');
  await visit.page.click('a[href="#led"]');
  server.tell('helper', madeUpWalk(2000));
  server.tell('helper', madeUpWalk(2000, { device: 4, name: 'Chest camera', may_watch: false, walk: null }));
  await visit.sees('6.4 m to go');
  await shoot('led');
  await visit.page.click('a[href="#walks"]');
  await visit.page.waitForSelector('.timeline img');
  tellRecording(server, 'recording', 17, 'evening');
  await visit.sees('17 pictures');
  await visit.sees('3 kitchen', '.coverage');
  await shoot('walks');
  await shootPart(visit, '.card:has(.coverage)', 'page-missing');
  await visit.page.click('a[href="#recognise"]');
  tellJob(server, 'running', 0.4, 'looking at pictures', 'learn');
  const file = join(folder, 'kitchen.png');
  writeFileSync(file, drawnRoom('kitchen', 3));
  const input = await visit.page.$('input[accept="image/jpeg,image/png,image/webp"]');
  await (input as unknown as { uploadFile: (path: string) => Promise<void> }).uploadFile(file);
  await visit.press('Which room is it?');
  await visit.sees('How likely each room is');
  await shoot('recognise');
  await askFromThePlan(visit);
  await shootPart(visit, '.card:has(.picker)', 'page-ask');
  await visit.page.click('a[href="#devices"]');
  await shoot('devices');
  await visit.press('Show a code');
  await visit.page.waitForSelector('.qr');
  await shoot('code');
  await visit.page.keyboard.press('Escape');
  await visit.page.click('a[href="#forget"]');
  await shoot('forget');
}

async function askFromThePlan(visit: Visit): Promise<void> {
  const { keyboard } = visit.page;
  await visit.page.focus('.picker');
  for (const key of ['ArrowRight', 'ArrowRight', 'ArrowDown', 'ArrowDown'] as const) {
    await keyboard.press(key);
  }
  await keyboard.press('Enter');
  await keyboard.down('Shift');
  await keyboard.press('ArrowUp');
  await keyboard.up('Shift');
  await keyboard.press('Enter');
  await visit.page.type('.card:has(.picker) input', 'Take me to the microwave');
  await keyboard.press('Enter');
  await visit.page.waitForSelector('.way');
  await visit.page.evaluate(() => document.querySelector('.announcement')?.remove());
}

// A part of the page as the manual shows it: docs/pictures/NAME.png, of the large window by day.
async function shootPart(visit: Visit, selector: string, name: string): Promise<void> {
  const isManuals = await visit.page.evaluate((width) => window.innerWidth === width && matchMedia('(prefers-color-scheme: light)').matches, kDesktop.width);
  if (isManuals) {
    await (await visit.page.$(selector))?.screenshot({ path: join(folder, `${name}.png`) as `${string}.png` });
  }
}

for (const [size, sizeName] of [[kPhone, 'small'], [kDesktop, 'large']] as const) {
  for (const dark of [false, true]) {
    for (const [role, visitAll] of [['device', phone], ['helper', helper]] as const) {
      await withServer(async (server) => {
        const visit = await openVisit(server, { role, size, dark });
        const shoot = async (name: string): Promise<void> => {
          const path = join(folder, `${role}-${name}-${sizeName}-${dark ? 'dark' : 'light'}.png`) as `${string}.png`;
          const isDialog = (await visit.page.$('dialog[open]')) !== null;
          await visit.page.screenshot({ path, fullPage: role === 'helper' && !isDialog });
        };
        await visitAll(visit, shoot, server);
        await visit.close();
      });
    }
  }
}
await closeBrowser();
