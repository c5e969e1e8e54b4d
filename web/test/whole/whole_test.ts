// The whole task of a helper and of a person who asks, by keyboard alone: the pages in Chromium, the real computer
// (`roomwise serve`), a real device (`roomwise device`, whose camera plays a simulated walk), and the browser's camera
// playing pictures of that walk.
import assert from 'node:assert/strict';
import { existsSync, mkdirSync, mkdtempSync, rmSync } from 'node:fs';
import { tmpdir } from 'node:os';
import { join } from 'node:path';
import { after, before, test } from 'node:test';
import type { Browser, FileChooser } from 'puppeteer-core';

import type { Home, Keyframe, RoomRange } from '../../src/shared/protocol';
import { kDesktop, kPages, kPhone, kWaiting, launchBrowser, openPage, skipReason, type Visit } from '../browser/harness';
import { goTo, heardOnce, recordSpeech, retype, shownCode, speaks, spoken } from '../browser/person';
import { HomeServer, Program } from './programs';
import { picturesIn, roomsOf, simulateWalk, standing, writeVideo, type Walk } from './walk';

const kLongWork = 180_000; // ms; mapping and learning take seconds here
const kHome = 'flat';
const kNames: Record<string, string> = { hall: 'corridor', toilet: 'bathroom' }; // as the helper calls the walk's rooms
const options = { skip: skipReason };

let folder: string;
let walk: Walk;
let server: HomeServer;
let browser: Browser;
let helper: Visit;
let phone: Visit;

// The steps follow each other: after one that failed, the others would only fail too.
let failed = false;
function step(name: string, run: () => Promise<void>): void {
  test(name, options, async () => {
    assert.ok(!failed, 'a step before this one failed');
    failed = true;
    await run();
    failed = false;
  });
}

before(async () => {
  if (skipReason !== false) {
    return;
  }
  folder = mkdtempSync(join(tmpdir(), 'roomwise-'));
  walk = await simulateWalk(folder);
  server = await HomeServer.start(folder, homeFile(), kPages);
  const video = join(folder, 'bathroom.mjpeg');
  writeVideo(picturesIn(walk, 'toilet', 10), video);
  browser = await launchBrowser({ acceptInsecureCerts: true, args: [`--use-file-for-fake-video-capture=${video}`] });
  helper = await openPage(browser, server.url);
  phone = await openPage(browser, server.url, { size: kPhone, before: recordSpeech });
});

after(async () => {
  await browser?.close();
  await server?.kill();
  if (folder) {
    rmSync(folder, { recursive: true, force: true });
  }
});

function homeFile(): string {
  return join(folder, `${kHome}.home`);
}

function device(...words: string[]): Program {
  return new Program(folder, ['device', '--server', `127.0.0.1:${server.port}`, '--name', 'Chest camera', '--speak', 'text', ...words]);
}

// What the computer tells a page that asks.
async function told<Answer>(visit: Visit, path: string): Promise<Answer> {
  return visit.page.evaluate(async (from) => (await fetch(from)).json() as Promise<never>, path) as Promise<Answer>;
}

// Waits until the computer does nothing that takes long.
async function idle(): Promise<void> {
  await helper.page.waitForFunction(async () => {
    const job = await (await fetch('/api/job')).json() as { state: string };
    return job.state !== 'running';
  }, { ...kWaiting, timeout: kLongWork });
}

async function assertFine(visit: Visit, what: string): Promise<void> {
  await visit.page.bringToFront(); // axe-core waits for a page in the background to be drawn
  await visit.assertAccessible(what);
  await visit.assertReflows();
  await shoot(visit, what);
}

// Pictures of the states for looking at, where ROOMWISE_SCREENSHOTS names a folder.
async function shoot(visit: Visit, what: string): Promise<void> {
  const shots = process.env['ROOMWISE_SCREENSHOTS'];
  if (!shots) {
    return;
  }
  mkdirSync(shots, { recursive: true });
  const size = visit.page.viewport();
  for (const [name, viewport] of [['small', kPhone], ['large', kDesktop]] as const) {
    for (const scheme of ['light', 'dark']) {
      await visit.page.setViewport({ ...viewport, hasTouch: size?.hasTouch ?? false }); // a change of touch loads anew
      await visit.page.emulateMediaFeatures([{ name: 'prefers-color-scheme', value: scheme }]);
      await visit.page.evaluate(async () => {
        await new Promise((resolve) => requestAnimationFrame(() => requestAnimationFrame(resolve)));
        await Promise.all(document.getAnimations().map((one) => one.finished)); // colours that change
      });
      await visit.page.screenshot({
        path: join(shots, `${what.replace(/\W+/g, '-')}-${name}-${scheme}.png`) as `${string}.png`,
        fullPage: visit === helper && (await visit.page.$('dialog[open]')) === null,
      });
    }
  }
  await visit.page.emulateMediaFeatures([
    { name: 'prefers-color-scheme', value: 'light' }, { name: 'prefers-reduced-motion', value: 'reduce' },
  ]);
  await visit.page.setViewport(size);
}

// ---- the helper makes the home known ----

step('a helper pairs with the code that the computer shows, and sees an empty home', async () => {
  await helper.go('/pair');
  await helper.sees('Pair this device');
  await helper.type(await server.helperCode());
  await helper.tabTo('Name of this device');
  await retype(helper, 'Kitchen tablet');
  await helper.page.keyboard.press('Enter');
  await helper.sees(kHome, 'h1');
  await helper.sees('Nothing is known of this home yet.');
  await helper.sees('There is no map yet.', '.stage-note');
  await helper.sees('Connected', '.chip');
  await assertFine(helper, 'an empty home');
});

step('a device is paired, recorded, watched and stopped; the map is made of it', async () => {
  await goTo(helper, 'Devices', 'Devices');
  const code = await shownCode(helper);
  const still = device('--pair', code, '--recording', standing(walk, walk.pictures[0]!, join(folder, 'standing')));
  await still.says(/Ready\./);
  await helper.sees('Chest camera', '.device-name');
  await goTo(helper, 'Walks', 'Walks');
  await helper.tabTo('Name of the walk');
  await retype(helper, 'first walk');
  await helper.press('Start recording');
  await heardOnce(helper, 'Recording first walk has started.');
  await helper.sees('Recording first walk, ', '.progress-words');
  await still.says(/Recording\./);
  // The person begins to walk. It is another program, whose camera takes up where the first one ended.
  still.press('x');
  await still.succeeds();
  const walking = device('--recording', walk.folder, '--rate', '4');
  await walking.says(/Recording\./);
  await assertFine(helper, 'recording');
  await walking.succeeds();
  const pictures = await helper.page.$$eval('.progress-words', (all) => /(\d+) pictures/.exec(all.map((one) => one.textContent).join())?.[1]);
  assert.ok(Number(pictures) > walk.pictures.length / 2, `${pictures} of ${walk.pictures.length} pictures came`);
  await helper.press('Stop recording');
  await helper.hears('Making the map');
  await helper.hears('The map is made.', kLongWork);
  const home = await told<Home>(helper, '/api/home');
  assert.equal(home.recordings[0]?.name, 'first walk');
  assert.equal(home.recordings[0]?.frames, roomsOf(recorded(), walk).length);
  const { keyframes } = await told<{ keyframes: Keyframe[] }>(helper, '/api/map/keyframes');
  assert.ok(keyframes.length > 20, `${keyframes.length} key-frames`);
  await helper.page.waitForFunction((count) => document.querySelectorAll('.timeline [role=option]').length === count, kWaiting, keyframes.length);
});

function recorded(): string {
  return join(`${homeFile()}.walks`, 'first walk');
}

step('the rooms of the walk are named', async () => {
  const [corridor, bathroom] = rangesOf(roomsOf(recorded(), walk));
  assert.ok(corridor && bathroom);
  const before = await told<{ keyframes: Keyframe[] }>(helper, '/api/map/keyframes');
  const picturesBefore = (frame: number): number => before.keyframes.filter((one) => one.frame < frame).length;
  // The first by choosing pictures, the second by typing numbers.
  const begin = await helper.page.$eval('.timeline [role=option]', (one) => (one as HTMLElement).innerText.replace(/\s+/g, ' ').trim());
  await helper.tabTo(begin);
  await helper.page.keyboard.down('Shift');
  while (Number(await valueOf('Last picture')) < picturesBefore(corridor.last - 3)) {
    await helper.page.keyboard.press('ArrowRight');
  }
  await helper.page.keyboard.up('Shift');
  const [first, last] = [await valueOf('First picture'), await valueOf('Last picture')];
  await helper.tabTo('Room');
  await helper.type(corridor.room);
  await helper.page.keyboard.press('Enter');
  await heardOnce(helper, `Pictures ${first} to ${last} are corridor now.`);
  const [from, to] = [picturesBefore(bathroom.first) + 1, before.keyframes.length];
  for (const [label, value] of [['First picture', from], ['Last picture', to], ['Room', bathroom.room]] as const) {
    await helper.tabTo(label);
    await retype(helper, String(value));
  }
  await helper.page.keyboard.press('Enter');
  await heardOnce(helper, `Pictures ${from} to ${to} are bathroom now.`);
  await helper.sees(`Pictures ${from} to ${to}, `, '.ranges');
  const { keyframes } = await told<{ keyframes: Keyframe[] }>(helper, '/api/map/keyframes');
  for (const keyframe of keyframes.filter(({ frame }) => frame >= bathroom.first)) {
    assert.equal(keyframe.room, 'bathroom', `the key-frame of frame ${keyframe.frame}`);
  }
  await assertFine(helper, 'walks');
});

function rangesOf(rooms: readonly string[]): RoomRange[] {
  const ranges: RoomRange[] = [];
  rooms.forEach((room, i) => {
    const newest = ranges[ranges.length - 1];
    if (newest && newest.room === kNames[room]) {
      newest.last = i;
    } else {
      ranges.push({ first: i, last: i, room: kNames[room] ?? room });
    }
  });
  return ranges;
}

async function valueOf(label: string): Promise<string> {
  return helper.page.$$eval('input', (all, wanted) => all.find((one) => one.labels?.[0]?.innerText.trim() === wanted)?.value ?? '', label);
}

step('the home is shown in three dimensions and in words', async () => {
  await goTo(helper, 'The home', 'The home');
  await helper.sees('2 rooms', '[role=status]');
  await helper.sees('corridor', 'h3');
  await helper.sees('Drag to turn', '.stage-note');
  await helper.page.waitForSelector('.room-label:not([hidden])');
  const fine = helper.page.waitForResponse((response) => response.url().endsWith('/api/map/cloud/fine'));
  await helper.press('From above');
  assert.ok((await (await fine).buffer()).length > 16 * 1000);
  await assertFine(helper, 'the home');
});

step('the rooms are learned, and a picture is tried', async () => {
  await goTo(helper, 'Recognise', 'Recognise');
  await helper.press('Learn now');
  await heardOnce(helper, 'Learning has started.');
  await helper.hears('The rooms are learned.', kLongWork);
  await helper.tabTo('Picture');
  const chooser = await openedChooser();
  await chooser.accept([picturesIn(walk, 'toilet', 1)[0]!.color]);
  await helper.press('Which room is it?');
  await helper.sees('bathroom', '.result .verdict-words');
  await helper.sees('bathroom', '.result table');
});

// A browser opens its dialog only for a key that it takes for a person's, which it now and then does not at first.
async function openedChooser(): Promise<FileChooser> {
  for (let tries = 0; tries < 5; tries += 1) {
    const choosing = helper.page.waitForFileChooser({ timeout: 10_000 }).catch(() => null);
    await helper.page.keyboard.press(' ');
    const chooser = await choosing;
    if (chooser) {
      return chooser;
    }
  }
  return assert.fail('no dialog for choosing a file opens');
}

step('what the device sees is recognised', async () => {
  const looking = device('--recording', standing(walk, picturesIn(walk, 'toilet', 1)[0]!, join(folder, 'looking')));
  await helper.sees('bathroom', '.recognitions .verdict-words');
  await helper.sees('Chest camera', '.recognitions');
  await assertFine(helper, 'recognise');
  looking.press('x');
  await looking.succeeds();
});

// ---- the person asks ----

// Asks, and gives the first words of the answer: they are announced once, and stand in the accessibility tree once for
// each time that they were said.
async function asked(ask: () => Promise<void>): Promise<string> {
  const before = (await phone.announced()).length;
  await ask();
  const answer = await phone.page.waitForFunction((count) => {
    const lines = [...document.querySelectorAll<HTMLElement>('[role=log] .line')].map((line) => line.innerText);
    return (window as unknown as { announced: string[] }).announced.slice(count).find((one) => lines.includes(one));
  }, { ...kWaiting, timeout: 120_000 }, before);
  const words = await answer.jsonValue() ?? '';
  const lines = await phone.page.$$eval('[role=log] .line', (all) => all.map((line) => (line as HTMLElement).innerText));
  const times = lines.filter((one) => one === words).length;
  assert.equal((await phone.announced()).slice(before).filter((one) => one === words).length, 1, words);
  assert.equal((await phone.accessibleTexts()).filter((one) => one === words).length, times, words);
  return words;
}

// As somebody does who is told to try again, or that there is no picture yet.
async function askedUntil(expected: RegExp, ask: () => Promise<void>): Promise<void> {
  const answers: string[] = [];
  while (!expected.test(answers[answers.length - 1] ?? '')) {
    assert.ok(answers.length < 20, `no answer is like ${expected}: ${JSON.stringify(answers)}`);
    answers.push(await asked(ask));
  }
}

step('a phone is paired and started', async () => {
  await goTo(helper, 'Devices', 'Devices');
  const code = await shownCode(helper);
  await phone.go('/pair');
  await phone.sees('Pair this device');
  await phone.type(code);
  await phone.tabTo('Name of this device');
  await retype(phone, "Anna's phone");
  await phone.page.keyboard.press('Enter');
  await phone.sees('Who shall speak?');
  await assertFine(phone, 'the start');
  await phone.tabTo("The phone's own voice");
  await phone.page.keyboard.press('ArrowDown');
  await phone.press('Start');
  await phone.sees('Connected', '.chip');
  await phone.sees('Camera sees', '.chip');
  await helper.sees("Anna's phone", '.device-name');
});

step('where am I, what is around me, where is something: each answer is heard once', async () => {
  await helper.sees('sees: bathroom', '.devices', kLongWork);
  assert.equal(await phone.focused(), 'Where am I');
  await askedUntil(/bathroom/, () => phone.page.keyboard.press('Enter'));
  await askedUntil(/around you|where you stand/, () => phone.press('What is around me'));
  await askedUntil(/^I know no bed here\.$/, async () => {
    await phone.press('Find…');
    await phone.tabTo('What are you looking for?');
    await phone.type('bed');
    await phone.page.keyboard.press('Enter');
  });
  assert.deepEqual(await spoken(phone), [], 'the screen reader speaks, and nobody else');
  await assertFine(phone, 'answers');
});

step('the computer is lost and comes back', async () => {
  const { port } = server;
  await server.kill();
  await phone.hears('The connection is lost.');
  await phone.sees('Not connected', '.chip');
  await helper.hears("The connection to the home's computer is lost");
  await assertFine(phone, 'lost');
  server = await HomeServer.start(folder, homeFile(), kPages, port);
  await phone.hears('Connected again.');
  await phone.sees('Connected', '.chip');
  await helper.hears('Connected again.');
  await askedUntil(/bathroom/, () => phone.press('Where am I'));
});

step('the phone speaks by its own voice, and nothing is live then', async () => {
  await phone.page.reload();
  await phone.sees('Who shall speak?');
  await phone.tabTo('My screen reader');
  await phone.page.keyboard.press('ArrowUp');
  await phone.press('Start');
  await phone.sees('Camera sees', '.chip');
  for (let tries = 0; tries < 20 && !(await spoken(phone)).some((one) => one.includes('bathroom')); tries += 1) {
    const before = (await spoken(phone)).length;
    await phone.press('Where am I');
    await phone.page.waitForFunction((count) => (window as unknown as { spoken: string[] }).spoken.length > count, { ...kWaiting, timeout: 120_000 }, before);
  }
  await speaks(phone, 'bathroom');
  assert.deepEqual(await phone.announced(), []);
});

// ---- the helper forgets ----

step('a room is forgotten, and with it what was learned', async () => {
  await idle(); // a computer that is making the map ready again forgets nothing
  await goTo(helper, 'Forget', 'Forget');
  await assertFine(helper, 'forget');
  await helper.tabTo('Room');
  await helper.press('Forget a room');
  await heardOnce(helper, 'The room bathroom is forgotten.');
  await helper.press('Erase now');
  await helper.sees('It cannot be taken back.', 'dialog');
  await helper.press('Erase now');
  await heardOnce(helper, 'It is erased.');
  await phone.press('Where am I');
  // While the map is made ready again it has no place to go by.
  await phone.page.waitForFunction(() => (window as unknown as { spoken: { text: string }[] }).spoken
    .some((one) => /have not learned any rooms|do not know where you stand/.test(one.text)), kWaiting);
});

step('everything is forgotten', async () => {
  await helper.press('Forget everything');
  await helper.hears("This is not the home's name: flat.");
  await helper.type(kHome);
  await helper.page.keyboard.press('Enter');
  await heardOnce(helper, 'Everything is forgotten.');
  await goTo(helper, 'Recognise', 'Recognise');
  await helper.sees('Nothing yet.', '.recognitions');
  await goTo(helper, 'The home', 'The home');
  await helper.sees('Nothing is known of this home yet.');
  await helper.sees('There is no map yet.', '.stage-note');
  assert.equal(existsSync(`${homeFile()}.walks`), false, 'the pictures of the walk are gone');
  await phone.press('What is around me');
  await speaks(phone, 'I have no map of this home yet.');
  await assertFine(helper, 'a home that was forgotten');
  await phone.close();
  await helper.close();
});
