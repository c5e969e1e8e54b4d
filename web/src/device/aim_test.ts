import assert from 'node:assert/strict';
import { test } from 'node:test';

import type { Aim } from '../shared/protocol';
import { AimPlayer, kFastestMs, kSlowestMs, pulseOf, type Pulse } from './aim';

const pulse = (bearing_degrees: number, distance_m: number): Pulse => pulseOf({ bearing_degrees, distance_m });

test('the nearer, the faster; between bounds', () => {
  const rates = [1.5, 1.2, 0.9, 0.6, 0.3].map((metres) => pulse(0, metres).everyMs);
  assert.deepEqual(rates, [...new Set(rates)].sort((a, b) => b - a));
  assert.equal(pulse(0, 0).everyMs, kFastestMs);
  assert.equal(pulse(180, 1.5).everyMs, kSlowestMs);
});

test('it is fastest and highest where the camera points at the goal, to both sides alike', () => {
  for (const side of [1, -1]) {
    const turned = [0, 20, 45, 70, 90].map((degrees) => pulse(side * degrees, 0.6));
    const rates = turned.map((one) => one.everyMs);
    assert.deepEqual(rates, [...new Set(rates)].sort((a, b) => a - b));
    const heights = turned.map((one) => one.from);
    assert.deepEqual(heights, [...new Set(heights)].sort((a, b) => b - a));
  }
});

test('the side is told twice: for two ears, and by where the tone glides', () => {
  assert.deepEqual([pulse(0, 1).pan, pulse(0, 1).to - pulse(0, 1).from], [0, 0]);
  assert.deepEqual([pulse(8, 1).pan, pulse(-8, 1).pan], [0, 0], 'as near as headings are known');
  const [left, right] = [pulse(60, 1), pulse(-60, 1)];
  assert.ok(left.pan < -0.5 && left.to < left.from, JSON.stringify(left));
  assert.ok(right.pan > 0.5 && right.to > right.from, JSON.stringify(right));
  assert.deepEqual([pulse(90, 1).pan, pulse(-90, 1).pan], [-1, 1]);
  assert.deepEqual([pulse(150, 1).pan, pulse(-150, 1).pan], [-1, 1], 'behind: by the nearer side');
});

// On a clock that is moved by hand, which runs what is due.
class World {
  now = 1000;
  isSilent = true;
  readonly heard: number[] = []; // when
  private waiting: { at: number; run: () => void }[] = [];
  readonly player = new AimPlayer({
    now: () => this.now,
    after: (ms, run) => void this.waiting.push({ at: this.now + ms, run }),
    isSilent: () => this.isSilent,
    play: () => void this.heard.push(this.now),
  });

  at(distance_m: number): void {
    this.player.hear({ type: 'aim', t: this.now, bearing_degrees: 0, distance_m, valid_until_t: this.now + 1000 } satisfies Aim);
  }

  passes(ms: number): void {
    const until = this.now + ms;
    for (;;) {
      const next = this.waiting.filter(({ at }) => at <= until).sort((a, b) => a.at - b.at)[0];
      if (!next) {
        break;
      }
      this.waiting = this.waiting.filter((one) => one !== next);
      this.now = Math.max(this.now, next.at);
      next.run();
    }
    this.now = until;
  }
}

test('it pulses evenly while values come, however often', () => {
  const world = new World();
  for (let i = 0; i < 11; i += 1) {
    world.at(1);
    world.passes(250);
  }
  assert.deepEqual(world.heard, [1000, 1500, 2000, 2500, 3000, 3500]);
});

test('it ends within a second when no value comes any more, and is never late', () => {
  const world = new World();
  world.at(0.6);
  world.passes(10_000);
  assert.deepEqual(world.heard, [1000, 1300, 1600, 1900]);
  world.player.hear({ type: 'aim', t: 1000, bearing_degrees: 0, distance_m: 0.6, valid_until_t: 2000 }); // that was long on its way
  world.passes(10_000);
  assert.equal(world.heard.length, 4);
});

test('it goes by the newest value at once, and ends when it is stopped', () => {
  const world = new World();
  world.at(2);
  world.passes(150);
  world.at(0.3);
  assert.deepEqual(world.heard, [1000, 1150], 'the wait of before is over');
  world.player.stop();
  world.passes(1000);
  assert.deepEqual(world.heard, [1000, 1150]);
});

test('it is silent while somebody speaks', () => {
  const world = new World();
  world.isSilent = false;
  world.at(0.5);
  world.passes(600);
  assert.deepEqual(world.heard, []);
  world.isSilent = true;
  world.passes(300);
  assert.deepEqual(world.heard, [1750]);
});
