import assert from 'node:assert/strict';
import { test } from 'node:test';

import type { Priority } from '../shared/protocol';
import { PromptPlayer } from './prompt_player';
import type { QueuedPrompt } from './prompt_queue';

// A player on a simulated clock: every sound takes 200 ms, every prompt two seconds.
function makePlayer() {
  const world = { now: 0, heard: [] as string[], timers: [] as { at: number; run: () => void }[] };
  const after = (ms: number, run: () => void): void => {
    world.timers.push({ at: world.now + ms, run });
  };
  let stopped: () => void = () => undefined;
  const player = new PromptPlayer({
    now: () => world.now,
    sound: (sound) => {
      world.heard.push(`${world.now} (${sound})`);
      return 200;
    },
    after,
    speaker: () => ({
      say: (prompt, over) => {
        world.heard.push(`${world.now} ${prompt.text}`);
        let running = true;
        stopped = () => (running = false);
        after(2000, () => running && over());
      },
      stop: () => {
        world.heard.push(`${world.now} stop`);
        stopped();
      },
    }),
  });
  const runTo = (end: number): void => {
    for (;;) {
      world.timers.sort((a, b) => a.at - b.at);
      const next = world.timers[0];
      if (!next || next.at > end) {
        break;
      }
      world.timers.shift();
      world.now = next.at;
      next.run();
    }
    world.now = end;
  };
  return { player, world, runTo };
}

const prompt = (text: string, priority: Priority = 'answer'): QueuedPrompt => ({
  key: text, text, language: 'en', priority, sound: 'answer', valid_until_t: 1e9,
});

test('the sound comes before the words, and prompts follow each other', () => {
  const { player, world, runTo } = makePlayer();
  player.push(prompt('kitchen'));
  player.push(prompt('microwave'));
  runTo(10_000);
  assert.deepEqual(world.heard, ['0 (answer)', '200 kitchen', '2200 (answer)', '2400 microwave']);
});

test('a hazard stops what is being said; that is not gone on with', () => {
  const { player, world, runTo } = makePlayer();
  player.push(prompt('kitchen'));
  runTo(1000);
  player.push(prompt('stairs', 'hazard'));
  runTo(10_000);
  assert.deepEqual(world.heard, ['0 (answer)', '200 kitchen', '1000 stop', '1000 (answer)', '1200 stairs']);
});

test('hushed between sound and words, the words do not come', () => {
  const { player, world, runTo } = makePlayer();
  player.push(prompt('kitchen'));
  runTo(100);
  player.hush();
  player.push(prompt('corridor'));
  runTo(10_000);
  assert.deepEqual(world.heard, ['0 (answer)', '100 stop', '100 (answer)', '300 corridor']);
});

test('a hazard is not hushed', () => {
  const { player, world, runTo } = makePlayer();
  player.push(prompt('stairs', 'hazard'));
  runTo(500);
  player.setQuiet(true);
  runTo(5000);
  assert.deepEqual(world.heard, ['0 (answer)', '200 stairs']);
});

test('the second of two callouts comes by itself when the gap is over', () => {
  const { player, world, runTo } = makePlayer();
  player.push(prompt('kitchen', 'callout'));
  player.push(prompt('corridor', 'callout'));
  runTo(10_000);
  assert.deepEqual(world.heard, ['0 (answer)', '200 kitchen', '2950 (answer)', '3150 corridor']);
});
