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
  await visit.page.keyboard.press('KeyA');
  await visit.page.keyboard.up('Control');
  await visit.type(words);
}

// Said once, by whatever live region.
export async function heardOnce(visit: Visit, words: string): Promise<void> {
  await visit.hears(words);
  assert.equal((await visit.announced()).filter((one) => one.includes(words)).length, 1, words);
}

// Keeps what the phone's own voice would say; every utterance ends at once.
export function recordSpeech(): void {
  const world = window as unknown as { spoken: { text: string; lang: string }[] };
  world.spoken = [];
  const synthesis = {
    speak: (utterance: SpeechSynthesisUtterance) => {
      if (utterance.text.trim() !== '') {
        world.spoken.push({ text: utterance.text, lang: utterance.lang });
      }
      window.queueMicrotask(() => utterance.onend?.(new Event('end') as SpeechSynthesisEvent));
    },
    cancel: () => undefined,
    getVoices: () => [],
  };
  Object.defineProperty(window, 'speechSynthesis', { value: synthesis });
}

export async function spoken(visit: Visit): Promise<string[]> {
  return visit.page.evaluate(() => (window as unknown as { spoken: { text: string }[] }).spoken.map((one) => one.text));
}

export async function speaks(visit: Visit, words: string): Promise<void> {
  await visit.page.waitForFunction(
    (wanted) => (window as unknown as { spoken: { text: string }[] }).spoken.some((one) => one.text.includes(wanted)),
    { ...kWaiting, timeout: 120_000 }, words,
  ).catch(async () => assert.fail(`'${words}' was not spoken; only: ${JSON.stringify(await spoken(visit))}`));
}
