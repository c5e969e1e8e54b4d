// What a person does on the pages and hears from them.
import assert from 'node:assert/strict';

import { kWaiting, type Visit } from './harness';

export async function goTo(visit: Visit, part: string, heading: string): Promise<void> {
  await visit.press(part);
  await visit.sees(heading, 'h2');
}

// Chooses all that a field holds, and types over it.
export async function retype(visit: Visit, words: string): Promise<void> {
  await visit.page.keyboard.down('Control');
  await visit.page.keyboard.press('a');
  await visit.page.keyboard.up('Control');
  await visit.type(words);
}

// The six digits of a code that a helper has shown, for the next device.
export async function shownCode(helper: Visit): Promise<string> {
  await helper.press('Show a code');
  const code = await helper.page.waitForSelector('dialog .big-code');
  const digits = await code?.evaluate((one) => one.textContent ?? '');
  await helper.page.keyboard.press('Escape');
  return (digits ?? '').replace(' ', '');
}

// Said once, by whatever live region.
export async function heardOnce(visit: Visit, words: string): Promise<void> {
  await visit.hears(words);
  assert.equal((await visit.announced()).filter((one) => one.includes(words)).length, 1, words);
}

// Presses the mouse on the control of this name, and lets it go once `meanwhile` is over.
export async function pressWhile(visit: Visit, name: string, meanwhile: () => Promise<void>): Promise<void> {
  await visit.tabTo(name);
  const box = await visit.page.evaluate(() => {
    const { x, y, width, height } = (document.activeElement as Element).getBoundingClientRect();
    return { x: x + width / 2, y: y + height / 2 };
  });
  await visit.page.mouse.move(box.x, box.y);
  await visit.page.mouse.down();
  await meanwhile();
  assert.equal(await visit.focused(), name);
  await visit.page.mouse.up();
}

export interface HeldCamera {
  isHeld: boolean; // who asks for a camera waits
  tracks: MediaStreamTrack[]; // of the one that was given last
  give: (() => void) | null; // to who waits
}

// window.heldCamera. It runs in the page, after what makes up its camera.
export function holdCamera(): void {
  const world: HeldCamera = { isHeld: false, tracks: [], give: null };
  (window as unknown as { heldCamera: HeldCamera }).heldCamera = world;
  if (!('mediaDevices' in navigator)) {
    return; // the empty page before the first, in Firefox
  }
  const ask = navigator.mediaDevices.getUserMedia.bind(navigator.mediaDevices);
  navigator.mediaDevices.getUserMedia = async (what) => {
    if (world.isHeld) {
      await new Promise<void>((resolve) => (world.give = resolve));
    }
    const stream = await ask(what);
    world.tracks = stream.getTracks();
    return stream;
  };
}

export interface Voice {
  name: string;
  lang: string;
  localService: boolean;
  default: boolean;
}

interface SpeechWorld {
  spoken: { text: string; voice: string | null }[];
  phoneVoices?: Voice[] | 'late';
  tellVoices: (voices: Voice[]) => void;
}

// Keeps what the phone's own voice would say; every utterance ends at once. The phone has a voice of its own and one that
// speaks elsewhere, unless `phoneVoices` was set before.
export function recordSpeech(): void {
  const world = window as unknown as SpeechWorld;
  world.spoken = [];
  const usual = [
    { name: 'Elsewhere', lang: 'en-US', localService: false, default: true },
    { name: 'Here', lang: 'en-US', localService: true, default: false },
    { name: 'Hier', lang: 'de_DE', localService: true, default: false },
  ];
  let voices = world.phoneVoices === 'late' ? [] : world.phoneVoices ?? usual;
  const synthesis = Object.assign(new EventTarget(), {
    speak: (utterance: SpeechSynthesisUtterance) => {
      if (utterance.text.trim() !== '') {
        world.spoken.push({ text: utterance.text, voice: utterance.voice?.name ?? null });
      } else if (world.phoneVoices === 'late') {
        window.setTimeout(() => world.tellVoices(usual), 1000);
      }
      window.queueMicrotask(() => utterance.onend?.(new Event('end') as SpeechSynthesisEvent));
    },
    cancel: () => undefined,
    getVoices: () => voices,
  });
  world.tellVoices = (told) => {
    voices = told;
    synthesis.dispatchEvent(new Event('voiceschanged'));
  };
  Object.defineProperty(window, 'speechSynthesis', { value: synthesis });
  Object.defineProperty(window, 'SpeechSynthesisUtterance', { // the browser's own takes no voice but its own
    value: class {
      voice = null;
      onend = null;
      constructor(readonly text: string) {}
    },
  });
}

export async function spoken(visit: Visit): Promise<string[]> {
  return visit.page.evaluate(() => (window as unknown as { spoken: { text: string }[] }).spoken.map((one) => one.text));
}

// The voices that were used; null: the browser's choice.
export async function voicesUsed(visit: Visit): Promise<(string | null)[]> {
  return visit.page.evaluate(() => [...new Set((window as unknown as SpeechWorld).spoken.map((one) => one.voice))]);
}

export async function speaks(visit: Visit, words: string): Promise<void> {
  await visit.page.waitForFunction(
    (wanted) => (window as unknown as { spoken: { text: string }[] }).spoken.some((one) => one.text.includes(wanted)),
    { ...kWaiting, timeout: 120_000 }, words,
  ).catch(async () => assert.fail(`'${words}' was not spoken; only: ${JSON.stringify(await spoken(visit))}`));
}
