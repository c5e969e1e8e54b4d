// Recording with nothing but the phone: by augmented reality, or by an app where there is none.
import assert from 'node:assert/strict';
import { after, test } from 'node:test';
import { inflateSync } from 'node:zlib';

import { tellJob, tellRecording } from '../stand_in_api';
import type { Client, StandInServer } from '../stand_in_server';
import { madeUpXr, noXr, type XrWorld } from '../made_up_xr';
import { closeBrowser, gets, kPatience, kPhone, kWaiting, openVisit, skipReason, withServer, type Visit } from './harness';
import { holdCamera, speaks, recordSpeech, type HeldCamera } from './person';

after(closeBrowser);
const options = { skip: skipReason };

async function begin(visit: Visit): Promise<void> {
  await visit.go('/device');
  await visit.sees('Who shall speak?');
  await visit.page.focus('input[value=own]');
  await visit.page.keyboard.press('ArrowDown');
  await visit.press('Start');
  await visit.sees('Connected', '.chip');
  await visit.sees('Camera sees', '.chip');
}

async function change(visit: Visit, more: Partial<XrWorld>): Promise<void> {
  await visit.page.evaluate((values) => void Object.assign((window as unknown as { xrWorld: XrWorld }).xrWorld, values), more);
}

async function comes<What>(what: string, look: () => What | undefined | null | false): Promise<What> {
  const patience = Date.now() + kPatience;
  while (Date.now() < patience) {
    const found = look();
    if (found) {
      return found;
    }
    await new Promise((resolve) => setImmediate(resolve));
  }
  assert.fail(`${what} did not come`);
}

// The newest connection's frame, once one with depth has come.
function frameOf(server: StandInServer, role: 'helper' | 'device'): Promise<NonNullable<Client['newest']>> {
  const frames = (): Client['newest'][] => server.clients.filter((client) => client.role === role).map((client) => client.newest);
  return comes('a frame of augmented reality', () => frames().find((one) => one?.header.version === 2));
}

function depthOf(png: Buffer): number[][] {
  const at = png.indexOf('IDAT');
  const rows = inflateSync(png.subarray(at + 4, at + 4 + png.readUInt32BE(at - 4)));
  const [width, height] = [png.readUInt32BE(16), png.readUInt32BE(20)];
  return Array.from({ length: height }, (_, y) => Array.from({ length: width }, (__, x) => rows.readUInt16BE(y * (1 + 2 * width) + 1 + 2 * x)));
}

// The colours of the corner above and of the corner below.
async function cornersOf(visit: Visit, jpeg: Buffer): Promise<number[][]> {
  return visit.page.evaluate(async (base64) => {
    const bytes = Uint8Array.from(atob(base64), (one) => one.charCodeAt(0));
    const picture = await createImageBitmap(new Blob([bytes], { type: 'image/jpeg' }));
    const canvas = new OffscreenCanvas(picture.width, picture.height);
    const context = canvas.getContext('2d') as OffscreenCanvasRenderingContext2D;
    context.drawImage(picture, 0, 0);
    return [5, picture.height - 6].map((y) => [...context.getImageData(5, y, 1, 1).data]);
  }, jpeg.toString('base64'));
}

test('a walk is recorded by the phone’s own browser, by keyboard and ear alone', options, () => withServer(async (server) => {
  const visit = await openVisit(server, { role: 'helper', size: kPhone, before: madeUpXr });
  await begin(visit);
  await visit.press('Record the home');
  await visit.hears('Hold the phone upright and move');
  await visit.hears('Recording.');
  const [begun] = server.state.requests.filter((one) => one.startsWith('POST /api/recording '));
  assert.match(begun ?? '', /"device":1,"name":"walk \d{4}-\d\d-\d\d \d\d\.\d\d\.\d\d"/);
  await visit.sees('Stop recording', '.walk');

  const { header, color, depth } = await frameOf(server, 'helper');
  assert.deepEqual(header.camera, { width: 240, height: 320, fx: 240, fy: 240, cx: 119.5, cy: 159.5 });
  assert.deepEqual(header.depth, { width: 30, height: 40 });
  assert.deepEqual(header.pose?.position, [0.1, 1.4, 0]);
  assert.deepEqual([header.pose?.source, header.pose?.up], ['webxr', [0, 1, 0]]);
  const hello = server.newest('helper').hello?.camera;
  assert.deepEqual(hello, { ...header.camera, depth_units_per_metre: 1000, lens: 'webxr' });
  const grid = depthOf(depth);
  assert.deepEqual([grid.length, grid[0]?.length, grid[20]?.[2], grid[20]?.[27]], [40, 30, 3000, 1500], 'right is right');
  const [above, below] = await cornersOf(visit, color);
  assert.ok((above?.[0] ?? 0) > 150 && (above?.[2] ?? 0) < 100, `red is above: ${String(above)}`);
  assert.ok((below?.[2] ?? 0) > 150 && (below?.[0] ?? 0) < 100, `blue is below: ${String(below)}`);

  tellRecording(server, 'recording', 120);
  await visit.hears('Recording, 120 pictures.');
  await change(visit, { degreesPerSecond: 100 });
  await visit.hears('Move more slowly.');
  await change(visit, { degreesPerSecond: 0, isLost: true });
  await visit.hears('The phone lost its way.');
  await change(visit, { isLost: false });
  await visit.hears('Good, go on.');
  await visit.press('How far am I');
  await visit.hears('Recording, 120 pictures.');
  await visit.press('Name this room');
  await visit.press('kitchen');
  await visit.hears('This room is called kitchen now.');
  const sizes = await visit.page.$$eval('.walk .question', (all) => all.map((one) => one.getBoundingClientRect().height));
  assert.ok(sizes.length === 3 && sizes.every((height) => height >= 64), `for a thumb: ${String(sizes)}`);
  await visit.assertAccessible('the phone while it records');
  await visit.assertReflows();

  await visit.press('Stop recording');
  await visit.hears('The recording is saved.');
  await comes('hello of the usual camera', () => server.clients.some((client) => client.hello?.camera && !client.hello.camera.fx));
  tellJob(server, 'done', 1, '', 'map');
  await visit.hears('The map is made. Name and learn the rooms');
  await visit.sees('Where am I', '.question');
  assert.equal(await visit.focused(), 'Where am I');
  await visit.sees('Camera sees', '.chip');
  await gets(() => server.state.requests.filter((one) => one === 'POST /api/recording/stop').length, 1);
  await visit.close();
}));

test('the phone’s own voice tells how the recording goes', options, () => withServer(async (server) => {
  const visit = await openVisit(server, { role: 'helper', size: kPhone, before: [recordSpeech, madeUpXr] });
  await visit.go('/device');
  await visit.press('Start');
  await visit.sees('Camera sees', '.chip');
  await visit.press('Record the home');
  await speaks(visit, 'Recording.');
  tellRecording(server, 'recording', 40);
  await speaks(visit, 'Recording, 40 pictures.');
  await visit.close();
}));

test('who may not start a recording makes the phone ready, and a helper starts it', options, () => withServer(async (server) => {
  const visit = await openVisit(server, { role: 'device', size: kPhone, before: madeUpXr });
  await begin(visit);
  await visit.press('Record the home');
  await visit.hears('Ready. A helper starts the recording');
  await frameOf(server, 'device');
  tellRecording(server, 'recording', 1, 'evening', 3);
  await visit.hears('Recording.');
  tellRecording(server, 'saved', 17, 'evening', 3);
  await visit.hears('The recording is saved.');
  await visit.sees('Where am I', '.question');
  assert.deepEqual(server.state.requests.filter((one) => one.includes('/api/recording')), []);
  await visit.close();
}));

test('a view that is closed lets the recording wait; it is gone on with, or ended', options, () => withServer(async (server) => {
  const visit = await openVisit(server, { role: 'helper', size: kPhone, before: madeUpXr });
  await begin(visit);
  await visit.press('Record the home');
  await visit.hears('Recording.');
  await visit.page.evaluate(() => (window as unknown as { xrWorld: XrWorld }).xrWorld.close());
  await visit.hears('The recording waits.');
  await visit.press('Record the home');
  await visit.sees('Stop recording', '.walk');
  await frameOf(server, 'helper');
  await gets(() => server.state.requests.filter((one) => one.startsWith('POST /api/recording ')).length, 1, 'gone on with');
  await visit.page.evaluate(() => (window as unknown as { xrWorld: XrWorld }).xrWorld.close());
  await visit.press('Stop recording');
  await visit.hears('The recording is saved.');
  await visit.close();
}));

test('a recording that ended while the phone was away is over for its walker, too', options, () => withServer(async (server) => {
  const visit = await openVisit(server, { role: 'helper', size: kPhone, before: madeUpXr });
  await begin(visit);
  await visit.press('Record the home');
  await visit.hears('Recording.');
  await server.stop();
  await visit.hears('The connection is lost.');
  await server.start();
  await visit.hears('Connected again.');
  await visit.sees('Stop recording', '.walk');
  await server.stop();
  server.state.recording = null;
  await server.start();
  await visit.hears('The recording is over.');
  await visit.sees('Where am I', '.question');
  await visit.sees('Camera sees', '.chip');
  assert.equal((await visit.announced()).filter((one) => one === 'Recording.').length, 1, 'one that goes on is not told anew');
  await visit.close();
}));

test('a recording whose end the computer refuses is over for its walker all the same', options, () => withServer(async (server) => {
  const visit = await openVisit(server, { role: 'helper', size: kPhone, before: madeUpXr });
  await begin(visit);
  await visit.press('Record the home');
  await visit.hears('Recording.');
  server.state.recording = null;
  await visit.press('Stop recording');
  await visit.hears('The recording is over.');
  await visit.sees('Where am I', '.question');
  await visit.close();
}));

for (const [name, words] of [['NotAllowedError', 'Allow both for this page.'], ['InvalidStateError', 'Augmented reality did not start.']] as const) {
  test(`a session that is refused by ${name} is told of, and the phone goes on as before`, options, () => withServer(async (server) => {
    const visit = await openVisit(server, { role: 'helper', size: kPhone, before: madeUpXr });
    await begin(visit);
    await change(visit, { refuses: name });
    await visit.press('Record the home');
    await visit.hears(words);
    await visit.sees('Camera sees', '.chip');
    await change(visit, { refuses: null });
    await visit.press('Record the home');
    await visit.hears('Recording.');
    await visit.close();
  }));
}

test('a recording that the computer refuses is told of with its reason', options, () => withServer(async (server) => {
  const visit = await openVisit(server, { role: 'helper', size: kPhone, before: madeUpXr });
  await begin(visit);
  server.state.devices = [];
  await visit.press('Record the home');
  await visit.hears('The recording did not start. this device is not connected');
  await visit.sees('Where am I', '.question');
  await visit.close();
}));

test('a camera that comes while augmented reality has it is turned off, and comes back afterwards', options, () => withServer(async (server) => {
  const visit = await openVisit(server, { role: 'helper', size: kPhone, before: [madeUpXr, holdCamera] });
  await begin(visit);
  await visit.page.evaluate(() => {
    const world = (window as unknown as { heldCamera: HeldCamera }).heldCamera;
    world.isHeld = true;
    world.tracks.splice(0).forEach((track) => track.stop()); // so that it is asked for anew
  });
  await visit.page.waitForFunction(() => (window as unknown as { heldCamera: HeldCamera }).heldCamera.give !== null, kWaiting);
  await visit.press('Record the home');
  await visit.hears('Recording.');
  await visit.page.evaluate(() => {
    const world = (window as unknown as { heldCamera: HeldCamera }).heldCamera;
    world.isHeld = false;
    world.give?.();
  });
  await visit.page.waitForFunction(() => {
    const { tracks } = (window as unknown as { heldCamera: HeldCamera }).heldCamera;
    return tracks.length > 0 && tracks.every((track) => track.readyState === 'ended');
  }, kWaiting);
  await visit.press('Stop recording');
  await visit.hears('The recording is saved.');
  await visit.sees('Camera sees', '.chip');
  await visit.close();
}));

test('without augmented reality the page says which app records, and where its export goes', options, () => withServer(async (server) => {
  const visit = await openVisit(server, { role: 'helper', size: kPhone, before: noXr });
  await begin(visit);
  await visit.press('Record the home');
  await visit.sees('Record with an app', 'dialog h2');
  for (const app of ['3D Scanner App', 'Stray Scanner', 'Record3D', 'Polycam']) {
    await visit.sees(app, 'dialog li');
  }
  await visit.assertAccessible('which app records');
  await visit.page.keyboard.press('Escape');
  await visit.page.evaluate(() => history.replaceState(null, '', '/homes/flat-7/device'));
  await visit.press('Record the home');
  await visit.sees('Record with an app', 'dialog h2');
  assert.equal(await visit.page.$eval('dialog a', (link) => link.getAttribute('href')), '/homes/flat-7/#walks');
  await visit.page.keyboard.press('Escape');
  await visit.page.evaluate(() => history.replaceState(null, '', '/device'));
  await visit.press('Record the home');
  await visit.press('Hand in the export on the helper\'s page');
  await visit.page.waitForFunction(() => location.hash === '#walks', { ...kWaiting, timeout: kPatience });
  await visit.close();
}));
