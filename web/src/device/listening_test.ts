import assert from 'node:assert/strict';
import { test } from 'node:test';

import type { Priority } from '../shared/protocol';
import { Listening } from './listening';
import { LocalHearing } from './local_hearing';
import { PromptPlayer } from './prompt_player';
import type { QueuedPrompt } from './prompt_queue';

// A recogniser that hears what a test says. `starts`: false where the browser throws.
function makeListening(starts = true) {
  const world = { said: [] as string[], asked: [] as string[], failed: [] as string[], aborted: 0 };
  let recognition: EventTarget = new EventTarget();
  class Recognition extends EventTarget {
    lang = '';
    processLocally = false;
    start(): void {
      if (!starts) {
        throw new Error('InvalidStateError');
      }
      recognition = this;
    }
    abort(): void {
      world.aborted += 1;
    }
  }
  let over: () => void = () => undefined;
  const player = new PromptPlayer({
    now: () => 0,
    sound: () => 0,
    after: (_, run) => run(),
    lostAnswer: () => prompt('lost'),
    speaker: () => ({
      say: (spoken, done) => {
        world.said.push(spoken.text);
        over = done;
      },
      stop: () => world.said.push('stop'),
    }),
  });
  const listening = new Listening({
    hold: (hazardComes) => player.hold(hazardComes),
    release: () => player.release(),
    ask: (words) => world.asked.push(words),
    failed: (why) => world.failed.push(why),
    changed: () => undefined,
  });
  listening.offer(new LocalHearing(Recognition, 'en-US'));
  return {
    world, player, listening,
    hear: (transcript: string) => recognition.dispatchEvent(Object.assign(new Event('result'), { results: [[{ transcript }]] })),
    end: () => recognition.dispatchEvent(new Event('end')),
    finish: () => over(),
  };
}

const prompt = (text: string, priority: Priority = 'notice'): QueuedPrompt => ({
  key: text, text, language: 'en', priority, sound: 'answer', valid_until_t: 1e9,
});

test('while the phone listens nothing is said, and what waited is said afterwards', () => {
  const { world, player, listening, hear } = makeListening();
  listening.press();
  player.push(prompt('turn left'));
  player.push(prompt('kitchen', 'callout'));
  assert.deepEqual(world.said, []);
  hear(' where am I ');
  assert.deepEqual(world.asked, ['where am I']);
  assert.equal(listening.listens, false);
  assert.deepEqual(world.said, ['turn left']);
});

test('what is being said when the phone begins to listen is broken off, and begun again', () => {
  const { world, player, listening, end } = makeListening();
  player.push(prompt('connected'));
  listening.press();
  assert.deepEqual(world.said, ['connected', 'stop']);
  end();
  assert.deepEqual(world.failed, ['nothing']);
  assert.deepEqual(world.said, ['connected', 'stop', 'connected']);
});

test('a hazard ends the listening and is said at once; while one is said nobody listens', () => {
  const { world, player, listening, hear, finish } = makeListening();
  listening.press();
  player.push(prompt('obstacle', 'hazard'));
  assert.deepEqual(world.said, ['obstacle']);
  assert.equal(listening.listens, false);
  assert.equal(world.aborted, 1);
  hear('obstacle');
  assert.deepEqual(world.asked, [], 'what came too late');
  listening.press();
  assert.equal(listening.listens, false);
  finish();
  listening.press();
  assert.equal(listening.listens, true);
});

test('stopped, or refused by the browser, the phone speaks again', () => {
  const stopped = makeListening();
  stopped.listening.press();
  stopped.player.push(prompt('turn left'));
  stopped.listening.stop();
  assert.deepEqual(stopped.world.said, ['turn left']);
  assert.deepEqual(stopped.world.failed, []);
  const refused = makeListening(false);
  refused.listening.press();
  refused.player.push(prompt('turn left'));
  assert.equal(refused.listening.listens, false);
  assert.deepEqual(refused.world.failed, ['nothing']);
  assert.deepEqual(refused.world.said, ['turn left']);
});
