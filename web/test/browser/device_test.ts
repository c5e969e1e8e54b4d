import assert from 'node:assert/strict';
import { after, test } from 'node:test';

import { tellRecording } from '../stand_in_api';
import { makePrompt } from '../stand_in_server';
import { closeBrowser, gets, kDesktop, kFakeLens, kIsWebKit, kPhone, kWaiting, onlyInChromium, openVisit, skipReason, until, withServer, type Visit } from './harness';
import { heardOnce, recordSpeech, speaks, spoken, voicesUsed, type Voice } from './person';

after(closeBrowser);
const options = { skip: skipReason };

// A camera whose picture the test chooses: window.scene = 'room', 'dark' or 'covered'; 'turned' is the room upright.
function sceneCamera(): void {
  const world = window as unknown as { scene: string };
  world.scene = 'room';
  if (!('mediaDevices' in navigator)) {
    return; // the empty page before the first, in Firefox
  }
  navigator.mediaDevices.getUserMedia = async () => {
    const canvas = document.createElement('canvas');
    [canvas.width, canvas.height] = [640, 480];
    const context = canvas.getContext('2d') as CanvasRenderingContext2D;
    let count = 0;
    window.setInterval(() => {
      count += 1;
      if (world.scene === 'frozen') {
        return;
      }
      const isUpright = world.scene === 'turned';
      if (isUpright !== canvas.height > canvas.width) {
        [canvas.width, canvas.height] = isUpright ? [480, 640] : [640, 480];
      }
      context.fillStyle = world.scene === 'dark' ? '#030303' : '#9a6a5a';
      context.fillRect(0, 0, 640, 640);
      for (let i = 0; (world.scene === 'room' || isUpright) && i < 60; i += 1) {
        context.fillStyle = `rgb(${(i * 67) % 255}, ${(i * 29) % 255}, ${(i * 97) % 255})`;
        context.fillRect((i * 83 + count) % 600, (i * 59) % 440, 40, 40);
      }
    }, 50);
    const stream = canvas.captureStream(20);
    (window as unknown as { tracks: MediaStreamTrack[] }).tracks = stream.getTracks();
    return stream;
  };
}

// A recogniser on the phone, that hears what the test says: window.says(words); '' is nothing.
function understandsSpeech(): void {
  class Recognition extends EventTarget {
    static available = async (asked: { processLocally: boolean }): Promise<string> => (asked.processLocally ? 'available' : 'unavailable');
    lang = '';
    get processLocally(): boolean {
      return this.isLocal;
    }
    set processLocally(on: boolean) {
      this.isLocal = on;
    }
    private isLocal = false;
    start(): void {
      const world = window as unknown as { says: (words: string) => void; heardBy: unknown[] };
      world.heardBy = [...(world.heardBy ?? []), { lang: this.lang, processLocally: this.processLocally }];
      world.says = (words) => {
        if (words !== '') {
          this.dispatchEvent(Object.assign(new Event('result'), { results: [[{ transcript: words }]] }));
        }
        this.dispatchEvent(new Event('end'));
      };
    }
    abort(): void {
      this.dispatchEvent(new Event('end'));
    }
  }
  Object.assign(window, { SpeechRecognition: Recognition });
}

function noCamera(): void {
  if ('mediaDevices' in navigator) {
    navigator.mediaDevices.getUserMedia = () => Promise.reject(new Error('no camera'));
  }
}

// window.felt: what the hand would feel.
function keepVibrations(): void {
  const felt: unknown[] = [];
  Object.assign(window, { felt });
  Object.defineProperty(navigator, 'vibrate', { value: (pattern: unknown) => felt.push(pattern) > 0 });
}

async function start(visit: Visit, voice: 'own' | 'reader'): Promise<void> {
  await visit.go('/device');
  await visit.sees('Who shall speak?');
  if (voice === 'reader') {
    await visit.page.focus('input[value=own]');
    await visit.page.keyboard.press('ArrowDown');
  }
  await visit.press('Start');
  await visit.sees('Connected', '.chip');
  await visit.sees('Camera sees', '.chip');
}

async function setScene(visit: Visit, scene: string): Promise<void> {
  await visit.page.evaluate((name) => ((window as unknown as { scene: string }).scene = name), scene);
}

test('a device that is not paired is led to pairing', options, () => withServer(async (server) => {
  const visit = await openVisit(server, { size: kPhone });
  await visit.go('/device');
  await visit.press('Start');
  await visit.sees('Pair this device');
  await visit.close();
}));

test('ask and hear by keyboard alone: the screen reader gets each answer once', options, () => withServer(async (server) => {
  const visit = await openVisit(server, { role: 'device', size: kPhone, before: recordSpeech });
  await start(visit, 'reader');
  assert.equal(await visit.focused(), 'Where am I');
  await visit.page.keyboard.press('Enter');
  await visit.hears('You are in the kitchen.');
  await visit.press('What is around me');
  await visit.hears('Before you the dining table');
  const announced = await visit.announced();
  assert.equal(announced.filter((one) => one === 'You are in the kitchen.').length, 1);
  assert.equal((await visit.accessibleTexts()).filter((one) => one === 'You are in the kitchen.').length, 1);
  assert.deepEqual(await spoken(visit), [], 'never both ways');
  await gets(() => server.newest('device').asked.map((one) => one['question']), ['where_am_i', 'around_me']);
  await visit.close();
}));

test('the phone speaks with its own voice, and nothing is live then', options, () => withServer(async (server) => {
  const visit = await openVisit(server, { role: 'device', size: kPhone, before: recordSpeech });
  await start(visit, 'own');
  await visit.page.keyboard.press('Enter');
  await speaks(visit, 'You are in the kitchen.');
  await visit.sees('You are in the kitchen.', '[role=log]');
  assert.deepEqual((await spoken(visit)).length, 1);
  assert.deepEqual(await visit.announced(), []);
  assert.deepEqual(await voicesUsed(visit), ['Here'], 'not the one that speaks elsewhere, though it is the default');
  await visit.close();
}));

test('a voice that the browser tells of late is waited for', options, () => withServer(async (server) => {
  const late = (): void => void ((window as unknown as { phoneVoices: string }).phoneVoices = 'late');
  const visit = await openVisit(server, { role: 'device', size: kPhone, before: [late, recordSpeech] });
  await start(visit, 'own');
  await visit.page.keyboard.press('Enter');
  await speaks(visit, 'You are in the kitchen.');
  assert.deepEqual(await voicesUsed(visit), ['Here']);
  assert.deepEqual(await spoken(visit), ['You are in the kitchen.']);
  assert.deepEqual(await visit.announced(), []);
  await visit.close();
}));

test('without a voice on the phone the screen reader gets the words, and the page says so', options, () => withServer(async (server) => {
  const elsewhere = (): void => void ((window as unknown as { phoneVoices: Voice[] }).phoneVoices = [
    { name: 'Elsewhere', lang: 'en-US', localService: false, default: true },
    { name: 'Hier', lang: 'de-DE', localService: true, default: false },
  ]);
  const visit = await openVisit(server, { role: 'device', size: kPhone, before: [elsewhere, recordSpeech] });
  await start(visit, 'own');
  await visit.hears('This phone has no voice of its own for English.');
  await visit.sees('This phone has no voice of its own for English.', '[role=log]');
  await visit.page.keyboard.press('Enter');
  await visit.hears('You are in the kitchen.');
  assert.deepEqual(await spoken(visit), []);
  await visit.assertAccessible('no voice');
  await visit.page.evaluate(() => (window as unknown as { tellVoices: (voices: Voice[]) => void }).tellVoices([
    { name: 'Here', lang: 'en-US', localService: true, default: false },
  ]));
  await visit.press('What is around me');
  await speaks(visit, 'Before you the dining table');
  assert.deepEqual(await spoken(visit), ['Before you the dining table, to the right the stove.']);
  assert.deepEqual((await visit.announced()).map((one) => one.split(' ')[0]), ['This', 'You'], 'each once, never both ways');
  await visit.close();
}));

test('what a sound tells, the hand feels', options, () => withServer(async (server) => {
  const visit = await openVisit(server, { role: 'device', size: kPhone, before: keepVibrations });
  await start(visit, 'reader');
  const feels = async (pattern: number[]): Promise<void> => {
    await visit.page.waitForFunction(
      (wanted) => (window as unknown as { felt: unknown[] }).felt.map((one) => JSON.stringify(one)).includes(wanted),
      { ...kWaiting, timeout: 120_000 }, JSON.stringify(pattern));
  };
  server.tell('device', makePrompt({ key: 'stairs', text: 'Stop!', priority: 'hazard', sound: 'alert' }));
  await feels([120, 60, 120, 60, 120]);
  server.tell('device', makePrompt({ text: 'I am not sure.', sound: 'unsure' }));
  await feels([40, 80, 40]);
  server.tell('device', makePrompt({ key: 'guide', message: 'guide.turn_hour_left', text: 'Turn to 10 o\'clock.', sound: 'none' }));
  await feels([240, 100, 60]);
  await server.stop();
  await feels([300]);
  await server.start();
  await feels([40, 60, 40, 60, 120]);
  await visit.press('Settings');
  await visit.tabTo('Vibration');
  await visit.page.keyboard.press(' ');
  await visit.page.keyboard.press('Escape');
  const isBefore = await visit.page.evaluate(() => (window as unknown as { felt: unknown[] }).felt.length);
  server.tell('device', makePrompt({ key: 'stairs', text: 'Stop! Stairs.', priority: 'hazard', sound: 'alert' }));
  await visit.hears('Stop! Stairs.');
  assert.equal(await visit.page.evaluate(() => (window as unknown as { felt: unknown[] }).felt.length), isBefore);
  await visit.close();
}));

test('on small phones nothing lies over the newest answer and the buttons of who is led', options, () => withServer(async (server) => {
  for (const size of [kPhone, { width: 390, height: 664 }, { width: 320, height: 568 }]) {
    const visit = await openVisit(server, { role: 'device', size, before: recordSpeech });
    await start(visit, 'reader');
    await visit.press('Take me…');
    await visit.press('microwave');
    await visit.hears('Turn right');
    server.tell('device', makePrompt({ key: 'guide', message: 'guide.walk', text: 'Straight on, 2 metres, then left through the door.', sound: 'none' }));
    await visit.sees('Straight on', '.line.newest');
    await visit.page.evaluate(() => window.scrollTo(0, 0));
    const coveredAt = (selector: string): Promise<boolean> => visit.page.$eval(selector, (element) => {
      const { left, right, top, bottom } = element.getBoundingClientRect();
      return [top + 4, bottom - 4].some((y) => !element.contains(document.elementFromPoint((left + right) / 2, y)));
    });
    assert.equal(await coveredAt('.line.newest'), false, `the answer at ${size.width} px`);
    for (const name of ['What next', 'How far', 'Blocked', 'Pause', 'Go on', 'End', 'Lock screen']) {
      await visit.tabTo(name);
      assert.equal(await coveredAt(':focus'), false, `${name} at ${size.width} px`);
    }
    await visit.assertReflows();
    await visit.close();
  }
}));

test('close to the goal the hand feels pulses: of who is led alone, not while somebody speaks, and until something is asked', options, () => withServer(async (server) => {
  const visit = await openVisit(server, { role: 'device', size: kPhone, before: keepVibrations });
  await start(visit, 'reader');
  const pulses = (): Promise<number> =>
    visit.page.evaluate(() => (window as unknown as { felt: unknown[] }).felt.filter((one) => JSON.stringify(one) === '[30]').length);
  const aim = { type: 'aim', t: 0, bearing_degrees: -20, distance_m: 0.5, valid_until_t: 1e12 };
  const picturesPass = (): Promise<void> => {
    const { frames } = server.newest('device');
    return until(() => server.newest('device').frames > frames + 4);
  };
  server.tell('device', aim);
  await picturesPass();
  assert.equal(await pulses(), 0, 'nobody is led');
  await visit.press('Take me…');
  await visit.press('microwave');
  await visit.hears('Turn right');
  server.tell('device', makePrompt({ key: 'guide', message: 'guide.walk', text: 'Straight on. '.repeat(40), sound: 'none' }));
  await visit.hears('Straight on.');
  server.tell('device', aim);
  await picturesPass();
  assert.equal(await pulses(), 0, 'somebody speaks');
  await visit.press('Quiet'); // ends what is said
  await visit.page.waitForFunction(() => (window as unknown as { felt: unknown[] }).felt.filter((one) => JSON.stringify(one) === '[30]').length >= 3, kWaiting);
  await visit.press('Pause');
  const felt = await pulses();
  await picturesPass();
  assert.equal(await pulses(), felt);
  await visit.press('Settings');
  await visit.tabTo('Tone and vibration close to the goal');
  await visit.page.keyboard.press(' ');
  await visit.page.keyboard.press('Escape');
  server.tell('device', aim);
  await picturesPass();
  assert.equal(await pulses(), felt, 'it was turned off');
  await visit.close();
}));

test('in a pocket the page is locked: by keys it opens with Escape or two buttons, and focus comes back', options, () => withServer(async (server) => {
  const visit = await openVisit(server, { role: 'device', size: kPhone });
  await start(visit, 'reader');
  await visit.press('Take me…');
  await visit.press('microwave');
  await visit.hears('Turn right');
  const shown = (selector: string): Promise<boolean> => visit.page.$eval(selector, (one) => one.checkVisibility());
  await visit.press('Lock screen');
  assert.equal(await visit.focused(), 'Unlock');
  const hint = await visit.page.evaluate(() => document.getElementById(document.activeElement?.getAttribute('aria-describedby') ?? '')?.innerText);
  assert.match(hint ?? '', /^To unlock, press Unlock/);
  assert.deepEqual([await shown('.bar'), await shown('.guide'), await shown('.questions')], [false, false, false]);
  assert.equal(await visit.page.$eval('body', (body) => getComputedStyle(body).backgroundColor), 'rgb(0, 0, 0)');
  await visit.assertAccessible('locked');
  await visit.assertReflows();
  const { frames } = server.newest('device');
  await until(() => server.newest('device').frames > frames + 2); // it goes on seeing
  server.tell('device', makePrompt({ key: 'guide', message: 'guide.walk', text: 'Straight on, 2 metres.', sound: 'none' }));
  await visit.hears('Straight on, 2 metres.');
  assert.ok((await visit.accessibleTexts()).includes('Straight on, 2 metres.'), 'a screen reader gets what is said');
  await visit.page.keyboard.press('Enter');
  assert.equal(await visit.focused(), 'Yes, unlock');
  await visit.assertAccessible('asked once more');
  await visit.page.keyboard.press('Enter');
  assert.equal(await visit.focused(), 'Lock screen', 'focus comes back');
  assert.equal(await shown('.questions'), true);
  await visit.page.keyboard.press('Enter');
  server.tell('device', makePrompt({ key: 'guide', message: 'guide.there_ahead', text: 'You are there.', sound: 'back' }));
  await visit.hears('You are there.');
  assert.equal(await shown('.bar'), false, 'whoever has arrived opens it themselves');
  await visit.page.keyboard.press('Escape');
  assert.equal(await visit.focused(), 'Take me…', 'nobody is led any more');
  await visit.close();
}));

test('touches do not unlock it, but two in a row on its buttons', options, () => withServer(async (server) => {
  const visit = await openVisit(server, { role: 'device', size: kPhone });
  await start(visit, 'reader');
  await visit.press('Take me…');
  await visit.press('microwave');
  await visit.press('Lock screen');
  const { asked } = server.newest('device');
  const questions = asked.length;
  const isLocked = (): Promise<boolean> => visit.page.$eval('body', (body) => body.classList.contains('locked'));
  const touch = async (name: string): Promise<void> => {
    await visit.page.evaluate((words) => {
      const button = [...document.querySelectorAll<HTMLElement>('.cover button')].find((one) => one.innerText === words && one.checkVisibility());
      const { x, y, width, height } = (button as HTMLElement).getBoundingClientRect();
      Object.assign(window, { target: { x: x + width / 2, y: y + height / 2, width, height } });
    }, name);
    const { x, y, width, height } = await visit.page.evaluate(() => (window as unknown as { target: DOMRect }).target);
    assert.ok(width >= 44 && height >= 44, `${name} is ${width} by ${height}`);
    await visit.page.mouse.click(x, y);
  };
  for (let y = 4; y < kPhone.height; y += 24) {
    await visit.page.mouse.click(kPhone.width - 4, y);
  }
  assert.equal(await isLocked(), true);
  await touch('Unlock');
  assert.equal(await visit.focused(), 'Yes, unlock');
  await visit.page.mouse.click(kPhone.width - 4, kPhone.height / 2);
  assert.equal(await isLocked(), true);
  assert.equal(await visit.focused(), 'Unlock', 'a touch elsewhere begins anew');
  const places = await visit.page.$$eval('.cover button', (all) => all.map((one) => {
    one.hidden = false;
    return one.getBoundingClientRect().top;
  }));
  assert.ok((places[1] ?? 0) - (places[0] ?? 0) > kPhone.height / 2, `far apart: ${places.join()}`);
  await touch('Unlock');
  await touch('Yes, unlock');
  assert.equal(await isLocked(), false);
  assert.equal(asked.length, questions, 'nothing was asked meanwhile');
  await visit.close();
}));

test('find: by typing and by the list; what is asked again is repeated', options, () => withServer(async (server) => {
  const visit = await openVisit(server, { role: 'device', before: recordSpeech });
  await start(visit, 'reader');
  await visit.press('Find…');
  await visit.tabTo('What are you looking for?');
  await visit.type('wave');
  await visit.sees('1 in the list', '[role=status]');
  await visit.press('microwave');
  await visit.hears('The microwave is two metres');
  assert.equal(await visit.focused(), 'Find…', 'focus comes back');
  await visit.page.keyboard.press('Enter');
  await visit.press('Ask for it');
  await visit.sees('Type a thing, or choose one from the list.', '[role=alert]');
  await visit.type('my keys');
  await visit.page.keyboard.press('Enter');
  await visit.hears('The my keys is two metres');
  await gets(() => server.newest('device').asked.map((one) => one['thing']), ['microwave', 'my keys']);
  await visit.press('Repeat');
  await visit.hears('You are in the kitchen.');
  await visit.close();
}));

test('who has shown a thing may end it without a name', options, () => withServer(async (server) => {
  const visit = await openVisit(server, { role: 'device', size: kPhone });
  await start(visit, 'reader');
  await visit.press('Teach a thing');
  server.tell('device', makePrompt({ key: 'teaching', message: 'teach.enough', text: 'I have seen enough.', priority: 'notice' }));
  await visit.sees('What is it called?', 'dialog');
  await visit.page.keyboard.press('Escape');
  await visit.sees('Name it', '.tool');
  await visit.press('Stop teaching');
  await gets(() => server.newest('device').asked.map((one) => one['question']), ['teach_thing', 'stop_teaching']);
  server.tell('device', makePrompt({ key: 'teaching', message: 'teach.stopped', text: 'Stopped.', priority: 'notice' }));
  await visit.sees('Teach a thing', '.tool');
  assert.equal(await visit.focused(), 'Teach a thing');
  assert.equal((await visit.accessibleTexts()).includes('Stop teaching'), false);
  await visit.close();
}));

test('who ends it while the computer is gone is led no more', options, () => withServer(async (server) => {
  const visit = await openVisit(server, { role: 'device', size: kPhone });
  await start(visit, 'reader');
  await visit.press('Take me…');
  await visit.press('microwave');
  await visit.hears('Turn right');
  await server.stop();
  await visit.sees('Not connected', '.chip');
  await visit.press('End');
  assert.equal(await visit.page.$eval('.guide', (guide) => guide.checkVisibility()), false);
  assert.equal(await visit.focused(), 'Take me…');
  await server.start();
  await visit.sees('Connected', '.chip.good');
  await visit.close();
}));

test('places: one is marked with a name or without, gone back to, renamed, forgotten', options, () => withServer(async (server) => {
  const visit = await openVisit(server, { role: 'device', size: kPhone, before: recordSpeech });
  await start(visit, 'reader');
  server.tell('device', { type: 'home', spots: ['my chair'] });
  await visit.press('Places…');
  await visit.assertAccessible('places');
  await visit.tabTo('What is this place called?');
  await visit.type('my desk');
  await visit.page.keyboard.press('Enter');
  await visit.hears('my desk is marked here.');
  assert.equal(await visit.focused(), 'Places…', 'focus comes back');
  await visit.page.keyboard.press('Enter');
  await visit.press('Mark this place');
  await visit.press('Places…');
  await visit.press('Take me back');
  assert.equal(await visit.page.$eval('.guide', (guide) => guide.checkVisibility()), true, 'is led');
  await visit.press('Places…');
  await visit.press('Rename my chair');
  assert.equal(await visit.page.$('dialog [role=status]'), null, 'there is no list to be counted');
  await visit.press('Rename');
  await visit.sees('Type a name', '[role=alert]');
  await visit.type('my seat');
  await visit.page.keyboard.press('Enter');
  await visit.press('Places…');
  await visit.press('Forget my chair');
  await visit.press('Take me…');
  await visit.press('my chair');
  const asked = (): unknown[] => server.newest('device').asked.map((one) => [one['question'], one['spot'] ?? one['thing'] ?? null, one['name'] ?? null]);
  await visit.hears('Turn right, then three metres straight on.');
  await gets(asked, [
    ['mark_spot', 'my desk', null], ['mark_spot', null, null], ['take_me_back', null, null], ['rename_spot', 'my chair', 'my seat'],
    ['forget_spot', 'my chair', null], ['take_me_to', 'my chair', null],
  ]);
  await visit.close();
}));

test('the way out is on the lists of what to find and where to be led, and asked for as itself', options, () => withServer(async (server) => {
  const visit = await openVisit(server, { role: 'device', size: kPhone, before: recordSpeech });
  await start(visit, 'reader');
  await visit.press('Take me…');
  await visit.press('way out');
  assert.equal(await visit.page.$eval('.guide', (guide) => guide.checkVisibility()), true, 'is led');
  await visit.press('Find…');
  await visit.press('way out');
  await gets(() => server.newest('device').asked.map((one) => [one['question'], one['goal'], one['thing']]), [
    ['take_me_to', 'way_out', undefined], ['where_is', 'way_out', undefined],
  ]);
  await visit.close();
}));

test('a question in one\'s own words, typed; whoever asks for a way is led', options, () => withServer(async (server) => {
  const visit = await openVisit(server, { role: 'device', size: kPhone, before: recordSpeech });
  await start(visit, 'reader');
  assert.equal(await visit.page.$eval('.speak', (speak) => speak.checkVisibility()), false, 'no microphone');
  await visit.press('Ask…');
  await visit.sees('This browser does not understand speech on the phone itself.', '.hint');
  await visit.page.keyboard.press('Enter');
  await visit.sees('Type a question', '[role=alert]');
  await visit.assertAccessible('nothing typed');
  await visit.type('where are my keys');
  await visit.page.keyboard.press('Enter');
  await visit.hears('You asked: where are my keys.');
  assert.equal(await visit.focused(), 'Ask…', 'the next question may answer');
  const isLed = (): Promise<boolean> => visit.page.$eval('.guide', (guide) => guide.checkVisibility());
  assert.equal(await isLed(), false);
  await visit.page.keyboard.press('Enter');
  await visit.type('take me to the bed');
  await visit.page.keyboard.press('Enter');
  await visit.hears('You asked: take me to the bed.');
  assert.equal(await isLed(), true);
  await gets(() => server.newest('device').asked.map((one) => [one['question'], one['text']]), [
    ['in_words', 'where are my keys'], ['in_words', 'take me to the bed'],
  ]);
  await visit.close();
}));

test('a question in one\'s own words, spoken, where the phone itself understands', options, () => withServer(async (server) => {
  const visit = await openVisit(server, { role: 'device', size: kPhone, before: [recordSpeech, understandsSpeech] });
  await start(visit, 'reader');
  const says = (what: string): Promise<void> =>
    visit.page.evaluate((event) => (window as unknown as { says: (what: string) => void }).says(event), what);
  await visit.press('Speak');
  await visit.sees('Listening…', '.speak[aria-pressed=true]');
  await visit.assertAccessible('listening');
  await says('Where is the sofa');
  await visit.hears('You asked: Where is the sofa.');
  await visit.press('Ask…');
  await visit.sees('this phone understands you by itself', '.hint');
  await visit.page.keyboard.press('Escape');
  await visit.press('Speak');
  await visit.sees('Listening…', '.speak[aria-pressed=true]');
  await says('');
  await visit.hears('I did not understand.');
  assert.deepEqual(await visit.page.evaluate(() => (window as unknown as { heardBy: unknown }).heardBy), [
    { lang: 'en-US', processLocally: true }, { lang: 'en-US', processLocally: true },
  ]);
  await gets(() => server.newest('device').asked.map((one) => one['text']), ['Where is the sofa']);
  await visit.close();
}));

test('naming the room in which one stands, while this device records', options, () => withServer(async (server) => {
  const visit = await openVisit(server, { role: 'device', size: kPhone });
  await start(visit, 'reader');
  const isOffered = (): Promise<boolean> => visit.page.$$eval('.tool', (all) => all.some((one) => one.textContent === 'Name this room' && one.checkVisibility()));
  assert.equal(await isOffered(), false);
  tellRecording(server, 'recording', 1, 'morning', 4); // another device's
  tellRecording(server, 'recording', 1, 'evening', 3);
  await visit.hears('Recording.');
  await visit.sees('Recording evening', '.chip');
  tellRecording(server, 'saved', 9, 'morning', 4);
  await visit.press('Name this room');
  await visit.press('kitchen');
  await visit.hears('This room is called kitchen now.');
  await gets(() => server.newest('device').asked[0]?.['room'], 'kitchen');
  tellRecording(server, 'saved', 17, 'evening', 3);
  await visit.hears('The recording is saved.');
  assert.equal((await visit.announced()).filter((one) => one.includes('saved')).length, 1);
  assert.equal(await isOffered(), false);
  await visit.close();
}));

test('quiet silences what nobody asked for, and is told to the computer', options, () => withServer(async (server) => {
  const visit = await openVisit(server, { role: 'device', size: kPhone, before: recordSpeech });
  await start(visit, 'own');
  await visit.press('Quiet');
  await speaks(visit, 'I only answer now.');
  await until(() => server.newest('device').told.length > 0);
  await gets(() => server.newest('device').told.at(-1), { type: 'quiet', on: true });
  assert.equal(await visit.page.$eval('.question.quiet', (one) => one.getAttribute('aria-pressed')), 'true');
  server.tell('device', makePrompt({ key: 'entered', text: 'Bathroom.', priority: 'callout' }));
  server.tell('device', makePrompt({ key: 'stairs', text: 'Stop!', priority: 'hazard', sound: 'alert' }));
  await speaks(visit, 'Stop!');
  assert.ok(!(await spoken(visit)).includes('Bathroom.'));
  await visit.close();
}));

test('a hazard is read at once, as an alert', options, () => withServer(async (server) => {
  const visit = await openVisit(server, { role: 'device', size: kPhone });
  await start(visit, 'reader');
  server.tell('device', makePrompt({ key: 'stairs', text: 'Stop! Stairs.', priority: 'hazard', sound: 'alert' }));
  await visit.sees('Stop! Stairs.', '[role=alert]');
  assert.equal((await visit.announced()).filter((one) => one === 'Stop! Stairs.').length, 1);
  await visit.close();
}));

test('while a dialog is open its own regions are read, hazards at once', options, () => withServer(async (server) => {
  const visit = await openVisit(server, { role: 'device', size: kPhone });
  await start(visit, 'reader');
  await visit.press('Ask…');
  server.tell('device', makePrompt({ key: 'guide', message: 'guide.walk', text: 'Straight on.', sound: 'none' }));
  await visit.hears('Straight on.');
  server.tell('device', makePrompt({ key: 'stairs', text: 'Stop! Stairs.', priority: 'hazard', sound: 'alert' }));
  await visit.hears('Stop! Stairs.');
  await visit.sees('Stop! Stairs.', 'dialog [role=alert]');
  await visit.assertAccessible('a hazard in a dialog');
  await visit.page.keyboard.press('Escape');
  await visit.sees('Stop! Stairs.', '.said-list');
  assert.deepEqual((await visit.announced()).filter((one) => one.startsWith('St')), ['Straight on.', 'Stop! Stairs.'], 'each once');
  server.tell('device', makePrompt({ key: 'teaching', message: 'teach.enough', text: 'I have seen enough.', priority: 'notice' }));
  await visit.hears('I have seen enough.'); // though it opens a dialog
  await visit.close();
}));

test('an answer that a hazard broke off is read again, and stands in the page once', options, () => withServer(async (server) => {
  const visit = await openVisit(server, { role: 'device', size: kPhone });
  await start(visit, 'reader');
  server.tell('device', makePrompt({ text: `You are in the kitchen${', which is large'.repeat(20)}.` }));
  await visit.hears('You are in the kitchen');
  server.tell('device', makePrompt({ key: 'stairs', text: 'Stop!', priority: 'hazard', sound: 'alert' }));
  await visit.page.waitForFunction(
    () => (window as unknown as { announced: string[] }).announced.map((one) => one.split(/[ ,]/)[0]).join() === 'You,Stop!,You');
  assert.equal((await visit.accessibleTexts()).filter((one) => one.startsWith('You are in the kitchen')).length, 1);
  await visit.close();
}));

test('frames flow one by one, and a frame that is not acknowledged holds the next', options, () => withServer(async (server) => {
  const visit = await openVisit(server, { role: 'device', size: kPhone });
  await start(visit, 'reader');
  await until(() => server.newest('device').frames >= 3);
  await gets(() => server.newest('device').hello?.camera, { width: 640, height: 480, lens: kFakeLens });
  server.acknowledges = false;
  const client = server.newest('device');
  await visit.hears('The connection is lost.');
  assert.ok(client.frames >= 4);
  server.acknowledges = true;
  await visit.hears('Connected again.');
  await visit.close();
}));

test('dark and covered cameras are said once, and that they see again', options, () => withServer(async (server) => {
  const visit = await openVisit(server, { role: 'device', size: kPhone, before: sceneCamera });
  await start(visit, 'reader');
  await setScene(visit, 'dark');
  await visit.hears('It is too dark for the camera.');
  await visit.sees('Camera: dark', '.chip');
  await setScene(visit, 'room');
  await visit.hears('The camera sees again.');
  await setScene(visit, 'covered');
  await visit.hears('The camera is covered.');
  assert.equal((await visit.announced()).filter((one) => one.includes('too dark')).length, 1);
  await visit.close();
}));

test('a camera that is taken away is said, and none of its old pictures are sent', options, () => withServer(async (server) => {
  const visit = await openVisit(server, { role: 'device', size: kPhone, before: sceneCamera });
  await start(visit, 'reader');
  await until(() => server.newest('device').frames >= 2);
  await setScene(visit, 'frozen');
  await visit.hears('The camera does not work.');
  await visit.sees('No camera', '.chip');
  const { frames } = server.newest('device');
  await visit.press('Where am I');
  await visit.hears('You are in the kitchen.');
  assert.equal(server.newest('device').frames, frames);
  await setScene(visit, 'room');
  await visit.hears('The camera sees again.');
  await until(() => server.newest('device').frames > frames);
  await visit.close();
}));

test('a camera that ended is started again, once', options, () => withServer(async (server) => {
  const visit = await openVisit(server, { role: 'device', size: kPhone, before: sceneCamera });
  await start(visit, 'reader');
  const end = (again: boolean): Promise<void> => visit.page.evaluate((works) => {
    if (!works) {
      navigator.mediaDevices.getUserMedia = () => Promise.reject(new Error('taken'));
    }
    (window as unknown as { tracks: MediaStreamTrack[] }).tracks.forEach((track) => track.stop());
  }, again);
  await end(true);
  const { frames } = server.newest('device');
  await until(() => server.newest('device').frames > frames + 2);
  assert.deepEqual(await visit.announced(), [], 'what is over at once is not said');
  await end(false);
  await visit.hears('The camera does not work.');
  await visit.sees('No camera', '.chip');
  await visit.close();
}));

test('a device that was removed is told so before it is led to pairing', options, () => withServer(async (server) => {
  const visit = await openVisit(server, { role: 'device', size: kPhone });
  await start(visit, 'reader');
  server.state.unpairAll();
  server.newest('device').socket.close();
  await visit.hears('This device was removed. Ask your helper.');
  await visit.sees('Pair this device');
  await visit.close();
}));

test('this device is unpaired after a question, and the person is told; not where the computer is not reached', options, () => withServer(async (server) => {
  const visit = await openVisit(server, { role: 'device', size: kPhone });
  await start(visit, 'reader');
  await visit.press('Settings');
  await visit.press('Unpair this device');
  await visit.sees('Unpair this device?', 'dialog h2');
  await visit.assertAccessible('whether to unpair');
  await visit.press('Cancel');
  assert.equal(await visit.focused(), 'Unpair this device');
  await visit.page.keyboard.press('Enter');
  await server.stop();
  await visit.press('Unpair this device');
  await visit.sees('was not reached', 'dialog [role=alert]');
  await server.start();
  await visit.press('Unpair this device');
  await visit.hears('This device is not paired any more.');
  await visit.sees('Pair this device');
  assert.equal((await visit.announced()).filter((one) => one.includes('was removed')).length, 0);
  await visit.close();
}));

test('what the computer cannot answer is told, in the language of the page', options, () => withServer(async (server) => {
  const visit = await openVisit(server, { role: 'device', size: kPhone });
  await start(visit, 'reader');
  server.answersQuestions = false;
  await visit.press('Where am I');
  await until(() => server.newest('device').asked.length === 1);
  server.tell('device', { type: 'error', text: "'thing' is missing", answer_to: server.newest('device').asked[0]?.['id'] });
  await visit.hears('That did not work. Please try again.');
  await visit.close();
}));

test('who waits long for an answer hears that it comes, and it is told though it is late', options, () => withServer(async (server) => {
  const visit = await openVisit(server, { role: 'device', size: kPhone });
  await start(visit, 'reader');
  server.answersQuestions = false;
  const isThere = setInterval(() => server.tell('device', { type: 'frame', t: 0 }), 200);
  try {
    let isHeard = false;
    for (let tries = 0; tries < 5 && !isHeard; tries += 1) { // on a busy machine it may have seemed gone meanwhile
      await visit.press('Where am I');
      isHeard = await visit.hears('One moment.', 8000).then(() => true, () => false);
    }
    assert.ok(isHeard);
    server.tell('device', makePrompt({ answer_to: server.newest('device').asked.at(-1)?.['id'] as number, valid_until_t: 1 }));
    await visit.hears('Earlier: You are in the kitchen.');
    assert.ok(!(await visit.announced()).some((one) => one.includes('did not work')));
  } finally {
    clearInterval(isThere);
  }
  await visit.close();
}));

test('no camera is said, and questions still work', options, () => withServer(async (server) => {
  const visit = await openVisit(server, { role: 'device', size: kPhone, before: noCamera });
  await visit.go('/device');
  await visit.page.click('input[value=reader]');
  await visit.press('Start');
  await visit.hears('The camera does not work.');
  await visit.sees('No camera', '.chip');
  await visit.press('Where am I');
  await visit.hears('You are in the kitchen.');
  await gets(() => server.newest('device').hello?.camera, null);
  await visit.close();
}));

test('a lost connection is said, questions meanwhile are answered by that, and it comes back', options, () => withServer(async (server) => {
  const visit = await openVisit(server, { role: 'device', size: kPhone });
  await start(visit, 'reader');
  const lost = visit.hears('The connection is lost.');
  await server.stop();
  await lost;
  await visit.sees('Not connected', '.chip');
  await visit.press('Where am I');
  await visit.page.waitForFunction(() => document.querySelectorAll('[role=log] .answer').length === 1);
  await server.start();
  await visit.hears('Connected again.');
  assert.equal((await visit.announced()).filter((one) => one.includes('is lost')).length, 2);
  await visit.press('Where am I');
  await visit.hears('You are in the kitchen.');
  await visit.close();
}));

test('who turns the phone while they are led is led on; that hello is said anew is no loss, unless the computer is gone', options, () => withServer(async (server) => {
  const visit = await openVisit(server, { role: 'device', size: kPhone, before: [sceneCamera, keepVibrations] });
  await start(visit, 'reader');
  const [lost, back] = ['[400,100,400]', '[40,60,40,60,120]'];
  const felt = (): Promise<string[]> => visit.page.evaluate(() => (window as unknown as { felt: unknown[] }).felt.map((one) => JSON.stringify(one)));
  const connectionFelt = async (): Promise<string[]> => (await felt()).filter((one) => one === lost || one === back);
  await visit.press('Take me…');
  await visit.press('microwave');
  await visit.hears('Turn right');
  await setScene(visit, 'turned');
  await until(() => server.newest('device').hello?.camera?.height === 640 && server.newest('device').frames > 2);
  server.tell('device', { type: 'seen', t: 1, verdict: 'room', room: 'kitchen', probability: 1, why: '', position: { x: 0, y: 0, z: 0, heading_degrees: 0, sigma_m: 0.1 } });
  await gets(() => server.newest('device').asked.map((one) => one['question']), ['take_me_to']);
  assert.deepEqual(await connectionFelt(), []);
  server.silent = true;
  await setScene(visit, 'room');
  await visit.hears('Stop. The connection is lost.');
  server.silent = false;
  await visit.hears('Connected again.');
  assert.deepEqual(await connectionFelt(), [lost, back]);
  await visit.close();
}));

test('a question that waits while hello is said anew is asked again, and answered once', options, () => withServer(async (server) => {
  const visit = await openVisit(server, { role: 'device', size: kPhone, before: sceneCamera });
  await start(visit, 'reader');
  server.answersQuestions = false;
  const before = server.newest('device');
  await visit.press('Where am I');
  await gets(() => before.asked.map((one) => one['question']), ['where_am_i']);
  server.answersQuestions = true;
  await setScene(visit, 'turned');
  await heardOnce(visit, 'You are in the kitchen.');
  assert.notEqual(server.newest('device'), before);
  await gets(() => server.newest('device').asked.map((one) => one['question']), ['where_am_i']);
  await visit.close();
}));

for (const [what, camera] of [['the scene is frozen', sceneCamera], ['there is no camera', noCamera]] as const) {
  test(`a computer that falls silent is noticed by a question, also where ${what}`, options, () => withServer(async (server) => {
    const visit = await openVisit(server, { role: 'device', size: kPhone, before: camera });
    await visit.go('/device');
    await visit.page.click('input[value=reader]');
    await visit.press('Start');
    await visit.sees('Connected', '.chip');
    if (camera === sceneCamera) {
      await setScene(visit, 'frozen');
    }
    await visit.hears('The camera does not work.'); // so no frame is under way
    const before = server.newest('device');
    server.silent = true;
    await visit.press('Where am I');
    await visit.hears('The connection is lost.');
    await visit.sees('Not connected', '.chip');
    server.silent = false;
    await visit.hears('Connected again.');
    assert.notEqual(server.newest('device'), before, 'by a socket of its own');
    await visit.press('Where am I');
    await visit.hears('You are in the kitchen.');
    assert.equal((await visit.announced()).filter((one) => one.includes('is lost')).length, 1);
    await visit.close();
  }));
}

test('the page opens while the computer is off, from what the service worker kept', options, () => withServer(async (server) => {
  const visit = await openVisit(server, { role: 'device', size: kPhone, guarded: false });
  await visit.go('/device');
  await visit.page.evaluate(() => navigator.serviceWorker.ready.then(() => true));
  await visit.page.waitForFunction(() => navigator.serviceWorker.controller !== null);
  const kept = await visit.page.evaluate(async () => {
    const requests = await Promise.all((await caches.keys()).map(async (name) => (await caches.open(name)).keys()));
    return requests.flat().map((request) => new URL(request.url).pathname);
  });
  assert.ok(kept.includes('/device.html') && kept.every((path) => !path.startsWith('/api')), JSON.stringify(kept));
  await server.stop();
  await visit.page.reload();
  await visit.page.click('input[value=reader]');
  await visit.press('Start');
  await (kIsWebKit ? visit.sees('Not connected', '.chip') : visit.hears('Looking for the computer.')); // there nothing listens where no server is
  await visit.close();
}));

test('settings: steps, German; they are kept, and told to the computer', options, () => withServer(async (server) => {
  const visit = await openVisit(server, { role: 'device', size: kPhone });
  await start(visit, 'reader');
  await visit.page.click('.tools button:last-child');
  await visit.sees('Who speaks');
  await visit.page.click('input[value=steps]');
  await until(() => server.newest('device').told.length > 0);
  await gets(() => server.newest('device').told[0], {
    type: 'settings', language: 'en', distances: 'steps', step_m: 0.7, callouts: true, may_watch: false,
  });
  await Promise.all([visit.page.waitForNavigation(), visit.page.click('button[lang=de]')]);
  await visit.sees('Wer soll sprechen?');
  await visit.press('Los');
  await visit.sees('Verbunden', '.chip');
  await gets(() => server.newest('device').hello?.language, 'de');
  await gets(() => server.newest('device').hello?.distances, 'steps');
  await visit.close();
}));

test('the page speaks Spanish and French, to axe-core as well', options, () => withServer(async (server) => {
  const visit = await openVisit(server, { role: 'device', size: kPhone });
  await start(visit, 'reader');
  for (const [tag, begin, settings, where] of [['es', 'Empezar', 'Ajustes', 'Dónde estoy'], ['fr', 'Commencer', 'Réglages', 'Où suis-je']] as const) {
    await visit.page.click('.tools button:last-child');
    await visit.page.waitForSelector(`button[lang=${tag}]`);
    await visit.assertAccessible(`settings, before ${tag}`);
    await Promise.all([visit.page.waitForNavigation(), visit.page.click(`button[lang=${tag}]`)]);
    await visit.press(begin);
    await visit.sees(settings, '.tools button:last-child');
    await visit.sees(where, '.question.where');
    await visit.assertAccessible(tag);
    await until(() => server.newest('device').hello?.language === tag);
  }
  await visit.close();
}));

for (const [size, name, schemes] of [
  [kPhone, 'phone', [false, true]], [kDesktop, 'desktop', [false, true]],
  [{ width: 320, height: 500 }, '320 px wide', [false]], // as with a magnification of 400 %
] as const) {
  for (const dark of schemes) {
    test(`axe-core finds nothing on the phone's page: ${name}, ${dark ? 'dark' : 'light'}`, options, () => withServer(async (server) => {
      const visit = await openVisit(server, { role: 'device', size, dark });
      await visit.go('/device');
      await visit.sees('Who shall speak?');
      await visit.assertAccessible('start');
      await visit.assertReflows();
      await start(visit, 'reader');
      await visit.page.keyboard.press('Enter');
      await visit.hears('You are in the kitchen.');
      await visit.assertAccessible('questions');
      await visit.assertReflows();
      await visit.press('Find…');
      await visit.sees('What are you looking for?');
      await visit.assertAccessible('find');
      await visit.page.keyboard.press('Escape');
      await visit.press('Settings');
      await visit.assertAccessible('settings');
      await visit.page.keyboard.press('Escape');
      await server.stop();
      await visit.sees('Not connected', '.chip');
      await visit.assertAccessible('connection lost');
      await visit.close();
    }));
  }
}

test('questions are large enough for a thumb', options, () => withServer(async (server) => {
  const visit = await openVisit(server, { role: 'device', size: kPhone });
  await start(visit, 'reader');
  const boxes = await visit.page.$$eval('.questions:not([hidden]) .question', (all) => all.map((one) => one.getBoundingClientRect().toJSON() as DOMRect));
  assert.equal(boxes.length, 5);
  for (const box of boxes) {
    assert.ok(box.height >= 64 && box.width >= 64, JSON.stringify(box));
    assert.ok(box.top >= kPhone.height / 2 - 40 && box.bottom <= kPhone.height, `in the lower part: ${JSON.stringify(box)}`);
  }
  await visit.close();
}));

test('the first load is small and stays in the home', { skip: onlyInChromium('bytes are not counted') }, () => withServer(async (server) => {
  const visit = await openVisit(server, { role: 'device', size: kPhone });
  await start(visit, 'reader');
  assert.ok(visit.bytes > 10_000 && visit.bytes < 2_000_000, `${visit.bytes} bytes`);
  console.log(`# first load of /device: ${visit.bytes} bytes`);
  await visit.close();
}));
