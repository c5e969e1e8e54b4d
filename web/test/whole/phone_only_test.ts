// A home is begun, recorded, named and learned with nothing but a phone: its browser in Chromium with a made-up session of
// augmented reality that plays a simulated walk, and the real computer. Then somebody asks and is led by another phone, which
// has no depth and which nobody calibrated: it is held upright on another walk, and heard through the accessibility tree.
import assert from 'node:assert/strict';
import { mkdtempSync, readFileSync, rmSync } from 'node:fs';
import { tmpdir } from 'node:os';
import { join } from 'node:path';
import { after, test } from 'node:test';
import type { Browser } from 'puppeteer-core';

import type { Home, Keyframe } from '../../src/shared/protocol';
import { kPages, kPhone, kWaiting, launchBrowser, openPage, skipReason, type Visit } from '../browser/harness';
import { goTo, shownCode } from '../browser/person';
import { ScreenReader } from '../browser/screen_reader';
import { playedCamera, type PlayedCamera } from './played_camera';
import { playedXr, type Played, type PlayedFrame } from './played_xr';
import { HomeServer } from './programs';
import { depthOf, posesOf, simulateUprightWalk, simulateWalk, type Walk } from './walk';

const kLongWork = 300_000; // ms
const kNames: Record<string, string> = { hall: 'corridor', toilet: 'bathroom' };
const kAtOnce = 10; // frames that the page is given

let browser: Browser | null = null;
let server: HomeServer | null = null;
let folder = '';
let helper: Visit | null = null;
after(async () => {
  await browser?.close();
  await server?.kill();
  if (folder) {
    rmSync(folder, { recursive: true, force: true });
  }
});

type Quaternion = [number, number, number, number]; // x, y, z, w

function product([ax, ay, az, aw]: Quaternion, [bx, by, bz, bw]: Quaternion): Quaternion {
  return [
    aw * bx + ax * bw + ay * bz - az * by, aw * by - ax * bz + ay * bw + az * bx,
    aw * bz + ax * by - ay * bx + az * bw, aw * bw - ax * bx - ay * by - az * bz,
  ];
}

// WebXR's world has y up and its cameras look back along z.
function playedFrame(walk: Walk, i: number, pose: { position: number[]; rotation: number[] }): PlayedFrame {
  const picture = walk.pictures[i] as Walk['pictures'][number];
  const [x = 0, y = 0, z = 0] = pose.position;
  const half = Math.SQRT1_2;
  const orientation = product(product([-half, 0, 0, half], pose.rotation as Quaternion), [-1, 0, 0, 0]);
  return {
    color: readFileSync(picture.color).toString('base64'), depth: Buffer.from(depthOf(picture.depth).buffer).toString('base64'),
    room: picture.room, position: [x, z, -y], orientation,
  };
}

async function played(visit: Visit): Promise<Played> {
  return visit.page.evaluate(() => (window as unknown as { played: Played }).played);
}

async function told<Answer>(visit: Visit, path: string): Promise<Answer> {
  return visit.page.evaluate(async (from) => (await fetch(from)).json() as Promise<never>, path) as Promise<Answer>;
}

test('a home is begun with nothing but a phone', { skip: skipReason }, async () => {
  folder = mkdtempSync(join(tmpdir(), 'roomwise-'));
  const walk = await simulateWalk(folder);
  const poses = posesOf(walk);
  const file = join(folder, 'flat.home');
  server = await HomeServer.start(folder, file, kPages);
  browser = await launchBrowser({ acceptInsecureCerts: true });
  const phone = await openPage(browser, server.url, { size: kPhone, before: playedXr });
  await phone.page.exposeFunction('playedFrames', (first: number) =>
    poses.slice(first, first + kAtOnce).map((pose, i) => playedFrame(walk, first + i, pose)));

  await phone.go('/pair');
  await phone.sees('Pair this device');
  await phone.type(await server.helperCode());
  await phone.press('Pair');
  await phone.sees('Nothing is known of this home yet.');
  await phone.go('/device');
  await phone.sees('Who shall speak?');
  await phone.page.focus('input[value=own]');
  await phone.page.keyboard.press('ArrowDown');
  await phone.press('Start');
  await phone.sees('Camera sees', '.chip');
  await phone.press('Record the home');
  await phone.hears('Recording'); // the word alone, or with how many pictures there are: obstacles are told first

  let named = '';
  for (let now = await played(phone); !now.isOver; now = await played(phone)) {
    if (now.room !== named && kNames[now.room]) {
      named = now.room;
      await phone.press('Name this room');
      await phone.tabTo('How is the room called in which you are?');
      await phone.type(kNames[named] ?? '');
      await phone.page.keyboard.press('Enter');
      await phone.page.waitForFunction(() => !document.querySelector('dialog[open]'), kWaiting);
    }
    await phone.page.waitForFunction((room) => {
      const { room: there, isOver } = (window as unknown as { played: Played }).played;
      return isOver || there !== room;
    }, { ...kWaiting, timeout: kLongWork }, named);
  }
  await phone.press('Stop recording');
  await phone.sees('Where am I', '.question');
  await phone.hears('The map is made.', kLongWork);

  const home = await told<Home>(phone, '/api/home');
  const [recording] = home.recordings;
  assert.ok(recording && recording.frames > walk.pictures.length / 2, `${recording?.frames} of ${walk.pictures.length} pictures came`);
  const motion = readFileSync(join(`${file}.walks`, recording.name, 'odometry.txt'), 'utf8');
  const up = /^# up (\S+) (\S+) (\S+)$/m.exec(motion)?.slice(1).map(Number) ?? [];
  assert.ok(up.length === 3 && [0, 1, 0].every((value, i) => Math.abs(value - up[i]!) < 1e-9), `up is ${up}`);
  assert.equal(motion.split('\n').filter((line) => line !== '' && !line.startsWith('#')).length, recording.frames);
  const { keyframes } = await told<{ keyframes: Keyframe[] }>(phone, '/api/map/keyframes');
  assert.ok(keyframes.length > 20, `${keyframes.length} key-frames`);
  assert.deepEqual([...new Set(recording.ranges.map(({ room }) => room))].sort(), ['bathroom', 'corridor']);

  await phone.go('/');
  await goTo(phone, 'Recognise', 'Recognise');
  await phone.press('Learn now');
  await phone.hears('The rooms are learned.', kLongWork);
  const learned = await told<Home>(phone, '/api/home');
  assert.deepEqual(learned.rooms.map(({ name }) => name).sort(), ['bathroom', 'corridor']);
  assert.ok(learned.learned);
  helper = phone;
});

// With a screen reader.
async function start(visit: Visit, reader: ScreenReader): Promise<void> {
  await visit.sees('Who shall speak?');
  while (!(await reader.focused()).startsWith("The phone's own voice")) {
    await visit.page.keyboard.press('Tab');
  }
  await visit.page.keyboard.press('ArrowDown');
  await reader.press('Start');
  await visit.sees('Camera sees', '.chip');
}

test('somebody asks and is led by another phone, without depth, that nobody calibrated', { skip: skipReason }, async () => {
  assert.ok(browser && server && helper, 'there is a home');
  await goTo(helper, 'The home', 'The home');
  await helper.press('Add a thing');
  await helper.type('sink'); // the first room of the list is the bathroom
  await helper.page.keyboard.press('Enter');
  await helper.hears('Added: sink.');
  await goTo(helper, 'Devices', 'Devices');
  const code = await shownCode(helper);

  const { pictures } = await simulateUprightWalk(folder);
  const walked = pictures.slice(pictures.findIndex(({ room }) => room === 'toilet') - 12); // from before the door
  const phone = await openPage(browser, server.url, { size: kPhone, before: playedCamera });
  await phone.page.exposeFunction('playedPicture', (which: number) => readFileSync(walked[which]!.color).toString('base64'));
  const reader = await ScreenReader.of(phone);
  const asks = async (answer: RegExp, ...ask: (() => Promise<void>)[]): Promise<void> => {
    const known = reader.heard.length;
    for (const one of ask) {
      await one();
    }
    await reader.hearsLike(answer, known);
  };
  const press = (name: string) => (): Promise<void> => reader.press(name);
  await phone.go('/pair');
  await phone.sees('Pair this device');
  await phone.type(code);
  await reader.press('Pair');
  await start(phone, reader);

  await asks(/^You are in the corridor\.$/, press('Where am I'));
  await asks(/^The sink is .*(o'clock|in the bathroom)/, press('Find…'), press('sink'));
  const inWords = async (): Promise<void> => {
    await phone.type('Which is the way to the sink?');
    await phone.page.keyboard.press('Enter');
  };
  await asks(/metres? to the sink\.$/, press('Ask…'), inWords);
  await asks(/^To the bathroom: about /, press('Take me…'), press('bathroom'));
  await reader.hearsLike(/^(The door is|Turn|A little|Straight on|Through)/, reader.heard.length);
  const known = reader.heard.length;
  await phone.page.evaluate((until) => void ((window as unknown as { playedCamera: PlayedCamera }).playedCamera.until = until), walked.length - 1);
  await reader.hearsLike(/^You are there, in the bathroom\.$/, known);
  assert.ok(!(await reader.names('button')).includes('End'), 'nobody is led any more');
  await asks(/sink/, press('What is around me'));
  await phone.close();
  await helper.close();
});
