// A home that is begun with photos of its rooms.
import assert from 'node:assert/strict';
import { mkdtempSync, rmSync, writeFileSync } from 'node:fs';
import { tmpdir } from 'node:os';
import { join } from 'node:path';
import { after, test } from 'node:test';
import type { ElementHandle } from 'puppeteer-core';

import { drawnRoom } from '../drawn_picture';
import { closeBrowser, gets, kPatience, kPhone, kWaiting, openVisit, skipReason, withServer, type Visit } from './harness';
import { goTo, heardOnce, holdCamera, type HeldCamera } from './person';

const folder = mkdtempSync(join(tmpdir(), 'roomwise-'));
after(async () => {
  rmSync(folder, { recursive: true });
  await closeBrowser();
});
const options = { skip: skipReason };

interface World {
  scene: 'room' | 'dark' | 'blurred' | 'covered';
  turned: number; // pixels that the picture moved by
  drawn: number; // pictures
  stopped: boolean;
}

function turningCamera(): void {
  const world: World = { scene: 'room', turned: 0, drawn: 0, stopped: false };
  (window as unknown as { turning: World }).turning = world;
  if (!('mediaDevices' in navigator)) {
    return; // the empty page before the first, in Firefox
  }
  navigator.mediaDevices.getUserMedia = async () => {
    const canvas = document.createElement('canvas');
    [canvas.width, canvas.height] = [640, 480];
    const context = canvas.getContext('2d') as CanvasRenderingContext2D;
    window.setInterval(() => {
      world.drawn += 1;
      context.filter = world.scene === 'blurred' ? 'blur(30px)' : 'none';
      context.fillStyle = world.scene === 'dark' ? '#030303' : '#8a7a6a';
      context.fillRect(0, 0, 640, 480);
      for (let i = 0; (world.scene === 'room' || world.scene === 'blurred') && i < 80; i += 1) {
        context.fillStyle = `rgb(${(i * 67) % 255}, ${(i * 29) % 255}, ${(i * 97) % 255})`;
        context.fillRect((i * 83 + world.turned) % 600, (i * 59) % 440, 40, 40);
      }
      context.fillStyle = `rgb(0, 0, ${world.drawn % 2})`; // a new picture, though it looks the same
      context.fillRect(0, 0, 2, 2);
    }, 50);
    const stream = canvas.captureStream(20);
    const [track] = stream.getVideoTracks();
    const stop = track?.stop.bind(track);
    if (track) {
      track.stop = () => {
        world.stopped = true;
        stop?.();
      };
    }
    return stream;
  };
}

// Waits until the camera shows it.
async function look(visit: Visit, more: Partial<World>): Promise<void> {
  const before = await visit.page.evaluate((values) => {
    const world = (window as unknown as { turning: World }).turning;
    Object.assign(world, values);
    return world.drawn;
  }, more);
  await visit.page.waitForFunction((since) => (window as unknown as { turning: World }).turning.drawn > since + 8, { ...kWaiting, timeout: kPatience }, before);
}

async function openTurn(visit: Visit, room: string): Promise<void> {
  await visit.tabTo('Room');
  await visit.type(room);
  await visit.press('Take photos in this room');
  await visit.sees(`Photos: ${room}`, 'dialog h2');
  await visit.page.waitForFunction(() => (document.querySelector('dialog video') as HTMLVideoElement | null)?.videoWidth, { ...kWaiting, timeout: kPatience });
}

test('a turn on the spot: dark, blurred and doubled photos are refused with the reason, and what is missing is told', options, () => withServer(async (server) => {
  const visit = await openVisit(server, { role: 'helper', size: kPhone, before: turningCamera });
  await visit.go('/');
  await goTo(visit, 'Recognise', 'Recognise');
  await visit.press('Take photos in this room');
  await visit.sees('Say which room it is.', '[role=alert]');
  await openTurn(visit, 'kitchen');
  assert.equal(await visit.focused(), 'Take a photo');
  await visit.assertAccessible('a turn on the spot');
  await visit.assertReflows();
  const take = async (words: string): Promise<void> => {
    await visit.page.keyboard.press('Enter');
    await visit.sees(words, '.turn-news');
    await visit.hears(words);
  };
  await look(visit, { scene: 'dark' });
  await take('it is too dark. Turn on a light.');
  await look(visit, { scene: 'blurred' });
  await take('it is blurred. Hold the phone still.');
  await look(visit, { scene: 'covered' });
  await take('it shows one plain surface');
  assert.equal(server.state.photos.size, 0);
  await look(visit, { scene: 'room' });
  await take('1 photo. Turn a little to the right. 2 more are needed.');
  await take('it shows the same as the last one. Turn a little.');
  await look(visit, { turned: 60 });
  await take('2 photos. Turn a little to the right. 1 more is needed.');
  await look(visit, { turned: 120 });
  await take('3 photos. That is enough for this room.');
  await visit.page.keyboard.press('Escape');
  await visit.sees('kitchen: 3 photos');
  // The camera is off; what plays it notices that when it draws next.
  await visit.page.waitForFunction(() => (window as unknown as { turning: World }).turning.stopped, kWaiting);
  await gets(() => server.state.photos.get('kitchen'), 3);
  await visit.press('Learn now');
  await heardOnce(visit, 'Learning has started.');
  await visit.press('Remove kitchen');
  await heardOnce(visit, 'The photos of kitchen are removed.');
  await visit.close();
}));

test('a camera that comes once its dialog is closed is turned off', options, () => withServer(async (server) => {
  const visit = await openVisit(server, { role: 'helper', before: [turningCamera, holdCamera] });
  await visit.go('/#recognise');
  await visit.page.evaluate(() => void ((window as unknown as { heldCamera: HeldCamera }).heldCamera.isHeld = true));
  await visit.tabTo('Room');
  await visit.type('hall');
  await visit.press('Take photos in this room');
  await visit.sees('Photos: hall', 'dialog h2');
  await visit.page.keyboard.press('Escape');
  await visit.page.evaluate(() => (window as unknown as { heldCamera: HeldCamera }).heldCamera.give?.());
  await visit.page.waitForFunction(() => {
    const { tracks } = (window as unknown as { heldCamera: HeldCamera }).heldCamera;
    return tracks.length > 0 && tracks.every((track) => track.readyState === 'ended');
  }, kWaiting);
  await visit.close();
}));

test('photos that are there already are checked alike, and what is refused is named', options, () => withServer(async (server) => {
  const visit = await openVisit(server, { role: 'helper' });
  const good = join(folder, 'good.png');
  const bad = join(folder, 'bad.jpg');
  writeFileSync(good, drawnRoom('kitchen', 1));
  writeFileSync(bad, 'no picture');
  await visit.go('/#recognise');
  await visit.sees('Begin with photos');
  await visit.tabTo('Room');
  await visit.type('dining kitchen');
  const input = await visit.page.evaluateHandle(() => [...document.querySelectorAll<HTMLInputElement>('input[type=file]')].find((one) => one.multiple));
  await (input as ElementHandle<HTMLInputElement>).uploadFile(good, bad);
  await visit.press('Add these photos');
  await visit.sees('bad.jpg: This is no picture that the browser can read.', '[role=alert]');
  await visit.sees('dining kitchen: 1 photo, 2 more are needed');
  await visit.hears('1 photo. 2 more are needed.');
  await gets(() => server.state.photos.get('dining kitchen'), 1);
  await visit.assertAccessible('photos that are there');
  await visit.close();
}));

test('where the connection is gone that is said once of all photos, and no more is sent', options, () => withServer(async (server) => {
  const visit = await openVisit(server, { role: 'helper', before: () => {
    const ask = window.fetch.bind(window);
    window.fetch = (...asked) => {
      if (!/\/photos$/.test(String(asked[0])) || asked[1]?.method !== 'POST') {
        return ask(...asked);
      }
      const tries = window as unknown as { tries?: number };
      tries.tries = (tries.tries ?? 0) + 1;
      return Promise.reject(new TypeError('gone'));
    };
  } });
  const paths = ['one.png', 'two.png'].map((name) => join(folder, name));
  paths.forEach((path) => writeFileSync(path, drawnRoom('kitchen', 1)));
  await visit.go('/#recognise');
  await visit.sees('Begin with photos');
  await visit.tabTo('Room');
  await visit.type('kitchen');
  const input = await visit.page.evaluateHandle(() => [...document.querySelectorAll<HTMLInputElement>('input[type=file]')].find((one) => one.multiple));
  await (input as ElementHandle<HTMLInputElement>).uploadFile(...paths);
  await visit.press('Add these photos');
  await visit.sees("one.png, two.png: The home's computer was not reached.", '[role=alert]');
  assert.equal(await visit.page.evaluate(() => (window as unknown as { tries?: number }).tries), 1);
  await visit.close();
}));

test('without a camera photos can still be chosen', options, () => withServer(async (server) => {
  const visit = await openVisit(server, { role: 'helper', before: () => {
    navigator.mediaDevices.getUserMedia = () => Promise.reject(new DOMException('no', 'NotAllowedError'));
  } });
  await visit.go('/#recognise');
  await visit.tabTo('Room');
  await visit.type('hall');
  await visit.press('Take photos in this room');
  await visit.sees('The camera is not allowed.', '.turn-news');
  await visit.close();
}));
