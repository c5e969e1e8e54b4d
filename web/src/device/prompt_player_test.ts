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
    sound: ({ sound }) => {
      world.heard.push(`${world.now} (${sound})`);
      return 200;
    },
    after,
    lostAnswer: (now) => ({ ...prompt('failed'), valid_until_t: now + 10_000 }),
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
  key: text, text, language: 'en', priority, sound: 'answer', valid_until_t: 1e9, answer_to: priority === 'answer' ? 1 : null,
});

test('it is silent when nobody speaks, nor is listened to', () => {
  const { player, runTo } = makePlayer();
  assert.equal(player.isSilent, true);
  player.push(prompt('kitchen'));
  assert.equal(player.isSilent, false, 'the sound of it comes first');
  runTo(2300);
  assert.equal(player.isSilent, true);
  player.hold(() => undefined);
  assert.equal(player.isSilent, false);
  player.release();
  assert.equal(player.isSilent, true);
});

test('the sound comes before the words, and prompts follow each other', () => {
  const { player, world, runTo } = makePlayer();
  player.push(prompt('kitchen'));
  player.push(prompt('microwave'));
  runTo(10_000);
  assert.deepEqual(world.heard, ['0 (answer)', '200 kitchen', '2200 (answer)', '2400 microwave']);
});

test('a hazard stops what is being said; an answer is begun again after it, a callout is not', () => {
  for (const [priority, again] of [['answer', ['3200 (answer)', '3400 kitchen']], ['callout', []]] as const) {
    const { player, world, runTo } = makePlayer();
    player.push(prompt('kitchen', priority));
    runTo(1000);
    player.push(prompt('stairs', 'hazard'));
    runTo(10_000);
    assert.deepEqual(world.heard, ['0 (answer)', '200 kitchen', '1000 stop', '1000 (answer)', '1200 stairs', ...again]);
  }
});

test('withdrawn between sound and words, an answer does not come', () => {
  const { player, world, runTo } = makePlayer();
  player.push(prompt('kitchen'));
  runTo(100);
  player.withdrawAnswers();
  player.push(prompt('corridor'));
  runTo(10_000);
  assert.deepEqual(world.heard, ['0 (answer)', '100 stop', '100 (answer)', '300 corridor']);
});

test('quiet ends what is spoken at once, but not a hazard', () => {
  for (const priority of ['notice', 'callout'] as const) {
    const { player, world, runTo } = makePlayer();
    player.push(prompt('dark', priority));
    runTo(500);
    player.setQuiet(true);
    runTo(5000);
    assert.deepEqual(world.heard, ['0 (answer)', '200 dark', '500 stop']);
  }
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

const kAround = ['around', 'around/2', 'around/3'];

test('asked while a longer answer is spoken: that ends, and the new question is answered', () => {
  const { player, world, runTo } = makePlayer();
  kAround.forEach((key) => player.push({ ...prompt(key), valid_until_t: 60_000 }));
  runTo(1000);
  player.withdrawAnswers();
  runTo(1500);
  player.push({ ...prompt('kitchen'), valid_until_t: 4000 });
  runTo(20_000);
  assert.deepEqual(world.heard, ['0 (answer)', '200 around', '1000 stop', '1500 (answer)', '1700 kitchen']);
});

test('asked while a hazard is spoken: the hazard stays, the older answer goes', () => {
  const { player, world, runTo } = makePlayer();
  kAround.forEach((key) => player.push(prompt(key)));
  player.push(prompt('stairs', 'hazard'));
  runTo(1000);
  player.withdrawAnswers();
  player.push(prompt('kitchen'));
  runTo(20_000);
  assert.deepEqual(world.heard.slice(-4), ['0 (answer)', '200 stairs', '2200 (answer)', '2400 kitchen']);
});

test('asked while a notice or a callout is spoken: the answer breaks it off; the notice comes again', () => {
  for (const [priority, again] of [['notice', ['3200 (answer)', '3400 dark']], ['callout', []]] as const) {
    const { player, world, runTo } = makePlayer();
    player.push(prompt('dark', priority));
    runTo(1000);
    player.withdrawAnswers();
    player.push(prompt('kitchen'));
    runTo(20_000);
    assert.deepEqual(world.heard, ['0 (answer)', '200 dark', '1000 stop', '1000 (answer)', '1200 kitchen', ...again]);
  }
});

test('quiet: no further sentence of an answer, but what that is for is said', () => {
  const { player, world, runTo } = makePlayer();
  kAround.forEach((key) => player.push(prompt(key)));
  runTo(1000);
  player.setQuiet(true);
  player.push(prompt('quiet'));
  runTo(20_000);
  assert.deepEqual(world.heard, ['0 (answer)', '200 around', '1000 stop', '1000 (answer)', '1200 quiet']);
});

test('an answer that comes too late, or waits too long, is told to have failed, once', () => {
  const { player, world, runTo } = makePlayer();
  runTo(1000);
  player.push({ ...prompt('late'), valid_until_t: 900 });
  runTo(5000);
  assert.deepEqual(world.heard, ['1000 (answer)', '1200 failed']);
  player.push(prompt('around'));
  player.push({ ...prompt('room'), valid_until_t: 6000 });
  player.push({ ...prompt('thing'), valid_until_t: 6000 });
  runTo(20_000);
  assert.deepEqual(world.heard.slice(2), ['5000 (answer)', '5200 around', '7200 (answer)', '7400 failed']);
});

test('the last words end what is spoken, and nothing follows them', () => {
  const { player, world, runTo } = makePlayer();
  player.push(prompt('stairs', 'hazard'));
  player.push(prompt('room'));
  runTo(1000);
  player.sayLast(prompt('removed'), () => world.heard.push(`${world.now} gone`));
  player.push(prompt('kitchen', 'hazard'));
  runTo(20_000);
  assert.deepEqual(world.heard, ['0 (answer)', '200 stairs', '1000 stop', '1000 (answer)', '1200 removed', '3200 gone']);
});
