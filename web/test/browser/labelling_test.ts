// The laboratory's labelling page, opened as a file, as roomwise-lab label leaves it.
import assert from 'node:assert/strict';
import { cpSync, mkdirSync, mkdtempSync, rmSync, writeFileSync } from 'node:fs';
import { tmpdir } from 'node:os';
import { join } from 'node:path';
import { after, test } from 'node:test';
import { pathToFileURL } from 'node:url';

import type { Labels } from '../../src/labelling/labels';
import { drawnRoom } from '../drawn_picture';
import { kDesktop, kPages, kPhone, launchBrowser, openPage, skipReason, type PageOptions, type Visit } from './harness';

const folder = mkdtempSync(join(tmpdir(), 'roomwise-'));
after(() => rmSync(folder, { recursive: true, force: true }));
const options = { skip: skipReason };

cpSync(join(kPages, '../labelling'), folder, { recursive: true });
mkdirSync(join(folder, 'pictures'));
const pictures = [4, 9, 30].map((frame) => ({ frame, file: `pictures/${frame}.png`, width: 320, height: 240 }));
pictures.forEach(({ file, frame }) => writeFileSync(join(folder, file), drawnRoom('kitchen', frame)));
writeFileSync(join(folder, 'recording.js'), `window.recording = ${JSON.stringify({ name: 'office', pictures, words: ['chair', 'table'] })};\n`);

async function withPage(page: PageOptions, run: (visit: Visit) => Promise<void>): Promise<void> {
  const browser = await launchBrowser({ args: ['--allow-file-access-from-files'] }); // axe-core reads the style sheet
  try {
    const visit = await openPage(browser, pathToFileURL(folder).href, page);
    await visit.go('/index.html');
    await visit.sees('Things in office', 'h1');
    await run(visit);
    await visit.close();
  } finally {
    await browser.close();
  }
}

function kept(visit: Visit): Promise<Labels> {
  return visit.page.evaluate(() => JSON.parse(localStorage.getItem('roomwise labels of office') ?? 'null') as Labels);
}

test('a thing is marked by mouse in one picture and by keyboard in the next', options, () => withPage({}, async (visit) => {
  await visit.tabTo('Name of the new thing');
  await visit.type('chair');
  await visit.page.keyboard.press('Enter');
  await visit.hears('Added. Draw its box on the picture.');
  const shown = await visit.page.$eval('svg.picture', (element) => element.getBoundingClientRect().toJSON() as DOMRect);
  const at = (x: number, y: number): [number, number] => [shown.x + (x * shown.width) / 320, shown.y + (y * shown.height) / 240];
  const drag = async (from: [number, number], to: [number, number]): Promise<void> => {
    await visit.page.mouse.move(...from);
    await visit.page.mouse.down();
    await visit.page.mouse.move(...to, { steps: 3 });
    await visit.page.mouse.up();
  };
  await drag(at(40, 30), at(120, 200));
  assert.deepEqual((await kept(visit)).things[0]?.views, [{ frame: 4, box: [40, 30, 120, 200], cut: [], occluded: false }]);
  await drag(at(120, 115), at(400, 115)); // its right side, out of the picture
  assert.deepEqual((await kept(visit)).things[0]?.views[0], { frame: 4, box: [40, 30, 320, 200], cut: ['right'], occluded: false });

  await visit.press('Next');
  await visit.sees('Picture 2 of 3 (frame 9)');
  await visit.press('Put a box in the middle');
  await visit.page.keyboard.press('ArrowLeft');
  await visit.page.keyboard.down('Shift');
  await visit.page.keyboard.press('ArrowDown');
  await visit.page.keyboard.up('Shift');
  assert.deepEqual((await kept(visit)).things[0]?.views[1]?.box, [127, 96, 191, 145]);
  await visit.page.keyboard.press('Delete');
  await visit.hears('The box is away.');
  assert.equal((await kept(visit)).things[0]?.views.length, 1);
  await visit.press('Undo');
  assert.equal((await kept(visit)).things[0]?.views.length, 2);
}));

test('what was drawn is there again after the page was closed, and what is missing is said when it is saved', options,
  () => withPage({}, async (visit) => {
    await visit.tabTo('Name of the new thing');
    await visit.type('table');
    await visit.page.keyboard.press('Enter');
    await visit.go('/index.html');
    await visit.sees('1 table', '.things');
    await visit.press('Save the file');
    await visit.hears('Saved, but not complete. Thing 1 (table) has no box.');
  }));

test("a file of another recording is refused in words, and nothing is lost", options, () => withPage({}, async (visit) => {
  await visit.tabTo('Name of the new thing');
  await visit.type('table');
  await visit.page.keyboard.press('Enter');
  const other = join(folder, 'other.json');
  writeFileSync(other, JSON.stringify({ recording: 'flat', reader: 'A', things: [] }));
  const input = await visit.page.$('input[type=file]');
  await (input as unknown as { uploadFile: (file: string) => Promise<void> }).uploadFile(other);
  await visit.hears('This file belongs to the recording flat, not to office.');
  await visit.sees('1 table', '.things');
}));

for (const [name, size, dark] of [['small', kPhone, false], ['large', kDesktop, true]] as const) {
  test(`axe-core finds nothing on the labelling page: ${name}`, options, () => withPage({ size, dark }, async (visit) => {
    await visit.assertAccessible('no thing');
    await visit.tabTo('Name of the new thing');
    await visit.type('chair');
    await visit.page.keyboard.press('Enter');
    await visit.press('Put a box in the middle');
    await visit.assertAccessible('a thing with a box');
    await visit.assertReflows();
  }));
}
