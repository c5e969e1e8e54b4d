import assert from 'node:assert/strict';
import { writeFileSync, mkdtempSync, rmSync } from 'node:fs';
import { tmpdir } from 'node:os';
import { join } from 'node:path';
import { after, test } from 'node:test';

import { drawnRoom } from '../drawn_picture';
import { kSecret, tellJob, tellRecording } from '../stand_in_api';
import { closeBrowser, gets, kDesktop, kPhone, onlyInChromium, openVisit, skipReason, withServer, type Visit } from './harness';
import { goTo, heardOnce, pressWhile, retype } from './person';

after(closeBrowser);
const options = { skip: skipReason };

test('who is not paired goes to pairing, a device to its own page', options, () => withServer(async (server) => {
  const visit = await openVisit(server);
  await visit.go('/');
  await visit.sees('Pair this device');
  await visit.close();
  const device = await openVisit(server, { role: 'device' });
  await device.go('/');
  await device.sees('Who shall speak?');
  await device.close();
}));

test('pairing a device: a code on one page, typed on the other, by keyboard alone', options, () => withServer(async (server) => {
  const helper = await openVisit(server, { role: 'helper' });
  await helper.go('/');
  await goTo(helper, 'Devices', 'Devices');
  await helper.press('Show a code');
  await helper.sees('314 159', 'dialog');
  assert.ok((await helper.accessibleTexts()).includes('The code is 3 1 4 1 5 9.'));
  const device = await openVisit(server, { size: kPhone });
  await device.go('/pair');
  await device.sees('Pair this device');
  assert.equal(await device.focused(), 'Code');
  await device.type('12345');
  await device.page.keyboard.press('Enter');
  await heardOnce(device, 'The code has six digits');
  await retype(device, '271828');
  await device.page.keyboard.press('Enter');
  await heardOnce(device, 'The code is wrong or no longer valid. Ask for a new one.');
  await retype(device, '314 159');
  await device.tabTo('Name of this device');
  await retype(device, 'ü'.repeat(40));
  await device.page.keyboard.press('Enter');
  await heardOnce(device, 'This name is too long.');
  assert.equal(await device.focused(), 'Name of this device');
  await retype(device, "Berta's phone");
  await device.page.keyboard.press('Enter');
  await device.sees('Who shall speak?');
  await device.close();
  await helper.page.keyboard.press('Escape');
  await helper.sees("Berta's phone", '.device-name');
  assert.equal(await helper.focused(), 'Show a code');
  await helper.close();
}));

test('the code may come in the address, and leaves it', options, () => withServer(async (server) => {
  server.state.codeRole = 'helper';
  const visit = await openVisit(server);
  await visit.go('/pair#314159');
  await visit.sees('Pair this device');
  await gets(() => visit.page.url(), `${server.url}/pair`);
  assert.equal(await visit.focused(), 'Pair');
  await visit.page.keyboard.press('Enter');
  await visit.sees('Our flat', 'h1');
  await visit.close();
}));

test('a link needs no digits, and says so where it is over', options, () => withServer(async (server) => {
  server.state.codeRole = 'helper';
  const visit = await openVisit(server);
  await visit.go(`/pair#${'x'.repeat(22)}`);
  await visit.sees('Opened from the code');
  await gets(() => visit.page.url(), `${server.url}/pair`);
  assert.equal(await visit.focused(), 'Pair');
  assert.equal(await visit.page.$('.code'), null);
  await visit.page.keyboard.press('Enter');
  await visit.sees('The code is wrong or no longer valid.');
  await visit.go(`/pair#${kSecret}`); // the page is open already
  await visit.sees('Opened from the code');
  await visit.page.keyboard.press('Enter');
  await visit.sees('Our flat', 'h1');
  await visit.close();
}));

test('revoking a device asks first, and is said once', options, () => withServer(async (server) => {
  const visit = await openVisit(server, { role: 'helper' });
  await visit.go('/#devices');
  await visit.sees('Chest camera', '.device-name');
  await visit.press('Remove Chest camera');
  await visit.sees('Remove Chest camera?', 'dialog');
  await visit.press('Remove');
  await heardOnce(visit, 'Chest camera is removed.');
  await gets(() => server.state.requests, ['DELETE /api/devices/4']);
  assert.equal(await visit.focused(), 'Paired devices', 'its row is gone');
  await visit.press("Rename Anna's phone");
  await retype(visit, 'Phone');
  await visit.page.keyboard.press('Enter');
  await heardOnce(visit, 'It is called Phone now.');
  assert.equal(await visit.focused(), 'Rename Phone', 'its row was drawn anew');
  await visit.close();
}));

test('a press on a device that is seen meanwhile is not lost', options, () => withServer(async (server) => {
  const visit = await openVisit(server, { role: 'helper' });
  await visit.go('/#devices');
  await visit.sees("Anna's phone", '.device-name');
  await visit.sees('Connected', '.chip');
  await pressWhile(visit, "Rename Anna's phone", async () => {
    server.tell('helper', {
      type: 'device', device: 3, name: "Anna's phone", online: true,
      seen: { t: 1, verdict: 'room', room: 'kitchen', probability: 0.97, why: '', position: null },
    });
    await visit.sees('kitchen (97%)', '.devices');
  });
  await visit.sees("What is Anna's phone to be called?", 'dialog h2');
  await visit.close();
}));

test('the home in words: rooms with their things, and a search', options, () => withServer(async (server) => {
  const visit = await openVisit(server, { role: 'helper' });
  await visit.go('/');
  await visit.sees('4 rooms, 10 things', '[role=status]');
  await visit.sees('9.6 m² · leads to corridor');
  await visit.tabTo('Search rooms and things');
  await visit.type('wave');
  await visit.hears('1 room, 1 thing');
  await visit.page.waitForFunction(() => document.querySelectorAll('.thing').length === 1);
  await visit.press('Picture microwave');
  await visit.page.waitForSelector('dialog .boxed svg');
  await visit.page.keyboard.press('Escape');
  assert.equal(await visit.focused(), 'Picture microwave');
  await visit.close();
}));

test('renaming a room, what is wrong beside its field, and deleting it', options, () => withServer(async (server) => {
  const visit = await openVisit(server, { role: 'helper' });
  await visit.go('/');
  await visit.press('Edit kitchen');
  assert.equal(await visit.focused(), 'Name');
  await retype(visit, 'bedroom');
  await visit.page.keyboard.press('Enter');
  await heardOnce(visit, "there is a room 'bedroom' already");
  assert.equal(await visit.focused(), 'Name');
  await retype(visit, 'cookery');
  await visit.page.keyboard.press('Enter');
  await heardOnce(visit, 'The room cookery is saved.');
  await visit.sees('cookery', 'h3');
  assert.equal(await visit.focused(), 'Edit cookery', 'its button was drawn anew');
  await gets(() => server.state.requests.at(-1), 'PUT /api/rooms/kitchen {"name":"cookery"}');
  await visit.press('Delete cookery');
  await visit.press('Delete');
  await heardOnce(visit, 'The room cookery is deleted.');
  await visit.sees('3 rooms, 10 things');
  await visit.close();
}));

test('what the computer refuses in its own words is read as English', options, () => withServer(async (server) => {
  const visit = await openVisit(server, { role: 'helper', before: () => localStorage.setItem('roomwise.language', 'de') });
  await visit.go('/');
  await visit.press('Ändern kitchen');
  await retype(visit, 'bedroom');
  await visit.page.keyboard.press('Enter');
  await visit.sees("there is a room 'bedroom' already", '[role=alert][lang=en]');
  await retype(visit, '');
  await visit.page.keyboard.press('Backspace');
  await visit.page.keyboard.press('Enter');
  await visit.sees('Geben Sie dem Raum einen Namen.', '[role=alert]:not([lang])');
  await visit.close();
}));

test('a dialog on a room that another helper renames meanwhile is closed with a sentence', options, () => withServer(async (server) => {
  const visit = await openVisit(server, { role: 'helper' });
  await visit.go('/');
  await visit.sees('Connected', '.chip');
  await visit.press('Edit kitchen');
  await visit.sees('Edit kitchen', 'dialog h2');
  const other = await openVisit(server, { role: 'helper' });
  await other.go('/');
  await other.press('Edit kitchen');
  await retype(other, 'cookery');
  await other.page.keyboard.press('Enter');
  await heardOnce(visit, 'The room kitchen was renamed or removed by somebody else meanwhile.');
  assert.equal(await visit.page.$('dialog'), null);
  await heardOnce(other, 'The room cookery is saved.');
  assert.ok(!(await other.announced()).some((one) => one.includes('meanwhile')), 'who does it is not told so');
  await other.close();
  await visit.close();
}));

test('correcting and removing a thing', options, () => withServer(async (server) => {
  const visit = await openVisit(server, { role: 'helper' });
  await visit.go('/');
  await visit.press('Correct washbasin');
  await retype(visit, 'sink');
  await visit.page.keyboard.press('Enter');
  await heardOnce(visit, 'It is called sink now.');
  await visit.press('Remove sink');
  await visit.press('Remove');
  await heardOnce(visit, 'Removed: sink.');
  await visit.sees('4 rooms, 9 things');
  await gets(() => server.state.requests, ['PUT /api/things/5 {"name":"sink"}', 'DELETE /api/things/5']);
  await visit.close();
}));

test('naming a room on the walk by keyboard alone', options, () => withServer(async (server) => {
  const visit = await openVisit(server, { role: 'helper' });
  await visit.go('/');
  await goTo(visit, 'Walks', 'Walks');
  await visit.tabTo('Picture 1, 0:00 corridor');
  for (let i = 0; i < 18; i += 1) {
    await visit.page.keyboard.press('ArrowRight');
  }
  assert.equal(await visit.focused(), 'Picture 19, 0:23 no name');
  await visit.page.keyboard.down('Shift');
  await visit.page.keyboard.press('End');
  await visit.page.keyboard.up('Shift');
  assert.equal((await visit.page.$$('[role=option][aria-selected=true]')).length, 6);
  await visit.tabTo('Room');
  await visit.page.keyboard.press('Enter');
  await heardOnce(visit, 'Give the room a name.');
  await visit.type('bedroom');
  await visit.page.keyboard.press('Enter');
  await heardOnce(visit, 'Pictures 19 to 24 are bedroom now.');
  await visit.sees('Pictures 19 to 24, 0:23 to 0:29: bedroom', '.ranges');
  assert.match(server.state.requests.at(-1) ?? '', /^PUT \/api\/recordings\/1\/rooms .*\{"first":72,"last":95,"room":"bedroom"\}\]\}$/);
  await visit.press('Remove Pictures 7 to 12, 0:07 to 0:14: kitchen');
  await heardOnce(visit, 'Pictures 7 to 12 have no name any more.');
  await visit.close();
}));

test('what a helper reads has no word of the machine room', options, () => withServer(async (server) => {
  tellJob(server, 'running', 0.4, 'adjusting landmarks', 'map');
  const visit = await openVisit(server, { role: 'helper' });
  await visit.go('/');
  await visit.sees('microwave', '.thing');
  for (const part of ['The home', 'Walks', 'Recognise', 'Devices', 'Forget']) {
    await goTo(visit, part, part);
    const words = (await visit.accessibleTexts()).join('\n');
    const found = /\b(key-?)?frames?\b|landmark|network\b|roomwise-compact|component|inlier|classifier|features|\(0\.\d/i.exec(words.replace(/homes' networks/g, ''));
    assert.equal(found?.[0], undefined, `on ${part}: ${words.slice(Math.max(0, (found?.index ?? 0) - 60), (found?.index ?? 0) + 60)}`);
  }
  await visit.close();
}));

test('pictures that are not there are refused beside their field', options, () => withServer(async (server) => {
  const visit = await openVisit(server, { role: 'helper' });
  await visit.go('/#walks');
  await visit.tabTo('Last picture');
  await retype(visit, '25');
  await visit.tabTo('Name these pictures');
  await visit.page.keyboard.press('Enter');
  await heardOnce(visit, 'Give a picture from 1 to 24.');
  assert.equal(await visit.focused(), 'Last picture');
  await visit.close();
}));

test('recording a walk: started, watched, stopped', options, () => withServer(async (server) => {
  const visit = await openVisit(server, { role: 'helper' });
  await visit.go('/#walks');
  await visit.tabTo('Name of the walk');
  await retype(visit, 'evening');
  assert.ok(!(await visit.accessibleTexts()).includes('Stop recording'), 'nothing is recorded yet');
  await visit.press('Start recording');
  await heardOnce(visit, 'Recording evening has started.');
  tellRecording(server, 'recording', 17);
  await visit.sees('17 pictures', '.progress-words');
  await visit.press('Stop recording');
  await heardOnce(visit, 'Recording has stopped; the map is made now.');
  await visit.sees('Making the map, 0%', '.progress-words');
  tellRecording(server, 'saved', 17);
  await visit.page.waitForFunction(() => document.activeElement?.textContent === 'Start recording');
  assert.ok(!(await visit.accessibleTexts()).includes('Stop recording'), 'nothing is recorded any more');
  await gets(() => server.state.requests, ['POST /api/recording {"device":3,"name":"evening"}', 'POST /api/recording/stop']);
  await visit.close();
}));

test('what is recorded is shown to who comes, and a recording that ended while the computer was away no longer', options, () => withServer(async (server) => {
  server.state.recording = { type: 'recording', device: 3, state: 'recording', name: 'evening', frames: 5, text: '' };
  const visit = await openVisit(server, { role: 'helper' });
  await visit.go('/#walks');
  await visit.sees('Recording evening, 5 pictures', '.progress-words');
  await visit.sees('Stop recording');
  await server.stop();
  server.state.recording = null;
  await server.start();
  await heardOnce(visit, 'Connected again.');
  assert.ok(!(await visit.accessibleTexts()).includes('Stop recording'), 'nothing is recorded any more');
  await visit.close();
}));

test('learning: progress is told in quarters, it can be stopped, its end is told', options, () => withServer(async (server) => {
  const visit = await openVisit(server, { role: 'helper' });
  await visit.go('/');
  await goTo(visit, 'Recognise', 'Recognise');
  await visit.press('Learn now');
  await heardOnce(visit, 'Learning has started.');
  for (const fraction of [0.1, 0.2, 0.3]) {
    tellJob(server, 'running', fraction, 'looking at pictures');
  }
  await visit.sees('30%', '.progress-words');
  const told = (await visit.announced()).filter((one) => one.startsWith('Learning the rooms'));
  assert.equal(told.length, 2, JSON.stringify(told)); // at the beginning and past a quarter
  await visit.press('Stop');
  await heardOnce(visit, 'Learning was stopped.');
  await visit.press('Learn now');
  tellJob(server, 'done', 1, 'done');
  await heardOnce(visit, 'The rooms are learned.');
  await visit.close();
}));

test('a job is one progress, told with what is done now, once for each stage and quarter', options, () => withServer(async (server) => {
  const visit = await openVisit(server, { role: 'helper' });
  await visit.go('/#walks');
  await visit.sees('Name of the walk');
  for (const [fraction, stage] of [[0.15, 'mapping'], [0.2, 'mapping'], [0.26, 'mapping'], [0.3, 'looking at key-frames'], [0.31, 'looking at key-frames']] as const) {
    tellJob(server, 'running', fraction, stage, 'map');
    await visit.sees(`, ${Math.round(100 * fraction)}%`, '.progress-words');
  }
  await visit.sees('Making the map, 31%. Looking for things, about 1 minute left', '.progress-words');
  const told = (await visit.announced()).filter((one) => one.startsWith('Making the map'));
  assert.deepEqual(told.map((one) => one.split(',')[1]), [
    ' 15%. Finding the place of each picture', ' 26%. Finding the place of each picture', ' 30%. Looking for things']);
  await visit.close();
}));

test('what a part of the page tells is heard while a dialog is open, too', options, () => withServer(async (server) => {
  const visit = await openVisit(server, { role: 'helper' });
  await visit.go('/#walks');
  await visit.press('Forget walk');
  await visit.sees('Forget the walk walk?', 'dialog');
  tellJob(server, 'running', 0.1, 'mapping', 'map');
  await heardOnce(visit, 'Making the map, 10%');
  tellJob(server, 'running', 0.6, 'mapping', 'map');
  await heardOnce(visit, 'Making the map, 60%');
  await visit.page.keyboard.press('Escape');
  tellJob(server, 'done', 1, '', 'map');
  await heardOnce(visit, 'The map is made.');
  await visit.close();
}));

test('trying a picture, and what is no picture', options, () => withServer(async (server) => {
  const folder = mkdtempSync(join(tmpdir(), 'roomwise-'));
  try {
    writeFileSync(join(folder, 'kitchen.png'), drawnRoom('kitchen', 2));
    writeFileSync(join(folder, 'letter.png'), 'Dear Anna');
    const visit = await openVisit(server, { role: 'helper' });
    await visit.go('/#recognise');
    await visit.press('Which room is it?');
    await heardOnce(visit, 'Choose a picture first.');
    const file = await visit.page.waitForSelector('input[accept="image/jpeg,image/png,image/webp"]');
    await (file as unknown as { uploadFile: (path: string) => Promise<void> }).uploadFile(join(folder, 'letter.png'));
    await visit.press('Which room is it?');
    await heardOnce(visit, 'this is no picture');
    await (file as unknown as { uploadFile: (path: string) => Promise<void> }).uploadFile(join(folder, 'kitchen.png'));
    await visit.press('Which room is it?');
    await visit.sees('How likely each room is', '.result');
    await heardOnce(visit, 'kitchen (94%)');
    await visit.close();
  } finally {
    rmSync(folder, { recursive: true });
  }
}));

test('forgetting needs the home’s name, typed', options, () => withServer(async (server) => {
  const visit = await openVisit(server, { role: 'helper' });
  await visit.go('/');
  await visit.sees('Drag to turn', '.stage-note');
  await goTo(visit, 'Recognise', 'Recognise');
  await visit.page.waitForSelector('.recognitions img');
  await goTo(visit, 'Forget', 'Forget');
  await visit.press('Forget everything');
  await heardOnce(visit, "This is not the home's name: Our flat.");
  assert.deepEqual(server.state.requests, []);
  await visit.type('Our flat');
  await visit.page.keyboard.press('Enter');
  await heardOnce(visit, 'Everything is forgotten.');
  await gets(() => server.state.requests, ['DELETE /api/home {"really":"Our flat"}']);
  await goTo(visit, 'The home', 'The home');
  await visit.sees('Nothing is known of this home yet.');
  await visit.sees('There is no map yet.', '.stage-note');
  await goTo(visit, 'Recognise', 'Recognise');
  await visit.sees('Nothing yet.', '.recognitions');
  await visit.close();
}));

test('forgetting a room and a walk', options, () => withServer(async (server) => {
  const visit = await openVisit(server, { role: 'helper' });
  await visit.go('/#forget');
  for (const [what, said] of [['Forget a room', 'The room corridor is forgotten.'], ['Forget a walk', 'The walk walk is forgotten.']] as const) {
    await visit.press(what);
    await heardOnce(visit, said);
  }
  await gets(() => server.state.requests, ['DELETE /api/rooms/corridor', 'POST /api/edits {"what":"take walk away","walk":1}']);
  await visit.close();
}));

test('the home in three dimensions: drawn, turned, a key-frame shown, devices placed', options, () => withServer(async (server) => {
  const visit = await openVisit(server, { role: 'helper' });
  await visit.go('/');
  await visit.page.waitForSelector('.stage canvas');
  await visit.page.waitForFunction(() => document.querySelector('.room-label:not([hidden])') !== null);
  const place = () => visit.page.$eval('.room-label', (one) => (one as HTMLElement).style.transform);
  const before = await place();
  await visit.press('Turn left');
  await visit.page.waitForFunction((was) => (document.querySelector('.room-label') as HTMLElement).style.transform !== was, {}, before);
  server.tell('helper', {
    type: 'device', device: 3, name: "Anna's phone", online: true,
    seen: { t: 1, verdict: 'room', room: 'kitchen', probability: 0.97, why: '', position: { x: 1.6, y: 3.4, z: 1.3, heading_degrees: 60, sigma_m: 0.05 } },
  });
  await visit.sees("Anna's phone", '.device-label');
  await visit.press('From above');
  // A click on each part of the picture in turn finds the walk somewhere.
  const stage = await (await visit.page.$('.stage canvas'))?.boundingBox();
  assert.ok(stage);
  let found = false;
  for (let row = 0; row < 40 && !found; row += 1) {
    for (let column = 0; column < 40 && !found; column += 1) {
      await visit.page.mouse.click(stage.x + (stage.width * (column + 0.5)) / 40, stage.y + (stage.height * (row + 0.5)) / 40);
      found = (await visit.page.$('.shown-picture img')) !== null;
    }
  }
  assert.ok(found, 'no click showed a key-frame');
  await visit.sees('Walk walk', '.shown-picture');
  await visit.close();
}));

test('the cloud comes when the map is ready', options, () => withServer(async (server) => {
  tellJob(server, 'running', 0.2, 'fusing the map', 'prepare');
  const visit = await openVisit(server, { role: 'helper' });
  await visit.go('/');
  await visit.sees('The map is being made ready', '.stage-note');
  await visit.sees('Making the map ready, 20%', '.progress-words');
  tellJob(server, 'done', 1, '', 'prepare');
  await heardOnce(visit, 'The map is ready.');
  await visit.sees('Drag to turn', '.stage-note');
  await visit.close();
}));

test('a lost connection is told, and all is fresh when it is back', options, () => withServer(async (server) => {
  const visit = await openVisit(server, { role: 'helper' });
  await visit.go('/');
  await visit.sees('Connected', '.chip');
  await server.stop();
  await heardOnce(visit, 'The connection to the home\'s computer is lost');
  server.state.home.rooms.push({ name: 'cellar', type: null, floor_m2: null, middle: null });
  await server.start();
  await heardOnce(visit, 'Connected again.');
  await visit.sees('cellar', 'h3');
  await visit.close();
}));

test('a computer that falls silent is noticed by a request, and all is fresh when it is back', options, () => withServer(async (server) => {
  const visit = await openVisit(server, { role: 'helper' });
  await visit.go('/');
  await visit.sees('Connected', '.chip');
  await goTo(visit, 'Devices', 'Devices');
  server.silent = true;
  await visit.press('Show a code');
  await heardOnce(visit, 'The connection to the home\'s computer is lost');
  await visit.sees('Not connected', '.chip');
  await visit.sees('The home\'s computer was not reached');
  server.state.home.rooms.push({ name: 'cellar', type: null, floor_m2: null, middle: null });
  server.silent = false;
  await heardOnce(visit, 'Connected again.');
  await visit.press('Show a code');
  await visit.sees('314 159', 'dialog');
  await visit.page.keyboard.press('Escape');
  await visit.press('The home');
  await visit.sees('cellar', 'h3');
  await visit.close();
}));

for (const [size, name, schemes] of [
  [kPhone, 'phone', [false, true]], [kDesktop, 'desktop', [false, true]],
  [{ width: 320, height: 568 }, '320 px wide', [false]], // as with a magnification of 400 %
] as const) {
  for (const dark of schemes) {
    test(`axe-core finds nothing on the helper's page and on pairing: ${name}, ${dark ? 'dark' : 'light'}`, options, () => withServer(async (server) => {
      const visit = await openVisit(server, { role: 'helper', size, dark });
      const check = async (what: string): Promise<void> => {
        await visit.assertAccessible(what);
        await visit.assertReflows();
      };
      await visit.go('/pair');
      await visit.sees('Pair this device');
      await check('pair');
      await visit.page.keyboard.press('Enter');
      await visit.sees('The code has six digits');
      await check('pair, with an error');
      await visit.go('/');
      await visit.sees('microwave', '.thing');
      await visit.page.waitForSelector('.room-label:not([hidden])');
      await check('the home');
      await visit.press('Edit kitchen');
      await check('editing a room');
      await visit.page.keyboard.press('Escape');
      for (const [part, there] of [['Walks', '[role=option] img'], ['Recognise', 'input[type=file]'], ['Devices', '.devices li'], ['Forget', '.danger']] as const) {
        await goTo(visit, part, part);
        await visit.page.waitForSelector(there);
        if (part === 'Recognise') {
          tellJob(server, 'running', 0.4, 'looking at pictures');
          await visit.sees('40%');
        }
        await check(part);
        if (part === 'Devices') {
          await visit.press('Show a code');
          await visit.page.waitForSelector('.qr');
          await check('the code');
          await visit.page.keyboard.press('Escape');
        }
      }
      await visit.press('Forget everything');
      await visit.sees("This is not the home's name");
      await check('forgetting, with an error');
      await visit.close();
    }));
  }
}

test('the first load is small, three.js with it; the fine cloud comes to who looks closer', options, () => withServer(async (server) => {
  const visit = await openVisit(server, { role: 'helper' });
  await visit.go('/');
  await visit.sees('Drag to turn', '.stage-note');
  await visit.page.waitForNetworkIdle();
  assert.ok(visit.bytes > 500_000 && visit.bytes < 2_000_000, `${visit.bytes} bytes`);
  console.log(`# first load of /: ${visit.bytes} bytes`);
  const fine = visit.page.waitForResponse((response) => response.url().endsWith('/api/map/cloud/fine'));
  await visit.press('Nearer');
  assert.ok((await (await fine).buffer()).length > 3_000_000);
  await visit.press('Turn left');
  await visit.page.waitForNetworkIdle();
  assert.equal(visit.requests.filter((url) => url.endsWith('/fine')).length, 1, 'it is fetched once');
  await visit.close();
}));

test('a message does not lie over what has the focus, and can be closed', options, () => withServer(async (server) => {
  const device = server.state.devices[2];
  assert.ok(device);
  device.name = 'The camera that Anna wears on her chest when she goes out into the garden behind the house with her dog';
  const visit = await openVisit(server, { role: 'helper', size: { width: 320, height: 568 } });
  await visit.go('/#devices');
  await visit.press(`Remove ${device.name}`);
  await visit.press('Remove');
  await visit.sees('is removed.', '.announcement');
  await visit.assertAccessible('a message');
  await visit.assertReflows();
  const passed = new Set<string>();
  for (let i = 0; i < 25; i += 1) {
    const { name, covered } = await visit.page.evaluate(() => new Promise<{ name: string; covered: boolean }>((resolve) => {
      requestAnimationFrame(() => requestAnimationFrame(() => {
        const focused = document.activeElement as HTMLElement;
        const { left, right, top, bottom } = focused.getBoundingClientRect();
        const at = [top + 2, bottom - 2].map((y) => document.elementFromPoint((left + right) / 2, y));
        resolve({ name: focused.innerText, covered: at.some((one) => one?.closest('.announcer') && !focused.closest('.announcer')) });
      }));
    }));
    assert.equal(covered, false, name);
    passed.add(name);
    await visit.page.keyboard.press('Tab');
  }
  assert.ok(passed.size > 6, [...passed].join());
  await visit.tabTo('Show a code');
  await visit.page.focus('.dismiss');
  await visit.page.keyboard.press('Enter');
  assert.equal(await visit.focused(), 'Show a code');
  assert.equal(await visit.page.$('.announcement'), null);
  await visit.close();
}));

// As a browser does that takes the person's own colours.
async function forceColours(visit: Visit): Promise<void> {
  const session = await visit.page.createCDPSession();
  await session.send('Emulation.setEmulatedMedia', { features: [{ name: 'forced-colors', value: 'active' }] });
}

const inChromium = { skip: onlyInChromium('colours are not forced') };
test('in forced colours what is chosen or pressed is seen', inChromium, () => withServer(async (server) => {
  const colourOf = (visit: Visit, selector: string): Promise<string> => visit.page.$eval(selector, (one) => getComputedStyle(one).backgroundColor);
  const helper = await openVisit(server, { role: 'helper' });
  await helper.go('/#walks');
  await helper.page.waitForSelector('.timeline [aria-selected=true]');
  await forceColours(helper);
  assert.notEqual(await colourOf(helper, '.timeline [aria-selected=true]'), await colourOf(helper, '.timeline [aria-selected=false]'));
  await helper.close();
  const device = await openVisit(server, { role: 'device', size: kPhone });
  await device.go('/device');
  await device.press('Start');
  await device.sees('Connected', '.chip');
  await device.press('Quiet');
  await forceColours(device);
  await device.page.waitForSelector('.quiet[aria-pressed=true]');
  assert.notEqual(await colourOf(device, '.question.quiet'), await colourOf(device, '.question.repeat'));
  await device.close();
}));

test('a name of another script leaves what follows it in its place, and long words break in narrow windows', options, () => withServer(async (server) => {
  const own = server.state.devices.find(({ device }) => device === 1);
  assert.ok(own);
  own.name = 'هاتف أحمد';
  const visit = await openVisit(server, { role: 'helper', size: { width: 320, height: 568 }, before: () => localStorage.setItem('roomwise.language', 'de') });
  await visit.go('/#devices');
  await visit.sees('(dieses)', '.device-name');
  assert.equal(await visit.page.$eval('.device-name bdi', (name) => name.textContent), own.name);
  await visit.sees('vertrauens', '.card');
  await visit.assertReflows();
  await visit.close();
}));
