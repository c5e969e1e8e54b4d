import assert from 'node:assert/strict';
import { test } from 'node:test';

import type { FramePose } from '../../shared/protocol';
import { kAgainMs, kLastsMs, WalkCoach, type WalkNews } from './walk_coach';

function pose(x: number, degrees = 0): FramePose {
  const half = (degrees * Math.PI) / 360;
  return { source: 'webxr', position: [x, 0, 0], rotation_xyzw: [0, Math.sin(half), 0, Math.cos(half)], up: [0, 1, 0], covariance: null };
}

// Takes five pictures a second for so long; what was said, by time.
function walk(coach: WalkCoach, from: number, seconds: number, at: (s: number) => Partial<Parameters<WalkCoach['see']>[0]>, pictures = (_: number): number => 0): [number, WalkNews][] {
  const said: [number, WalkNews][] = [];
  for (let t = from; t < from + 1000 * seconds; t += 200) {
    const news = coach.see({ t, pose: pose(0), hasDepth: true, isTurned: false, ...at((t - from) / 1000) }, pictures((t - from) / 1000));
    if (news.advice || news.isBetter || news.pictures !== null) {
      said.push([t - from, news]);
    }
  }
  return said;
}

test('who strolls and turns slowly hears nothing but how many pictures there are', () => {
  const said = walk(new WalkCoach(), 0, 30, (s) => ({ pose: pose(0.5 * s, 40 * s) }), (s) => Math.floor(5 * s));
  assert.deepEqual(said.map(([, news]) => [news.advice, news.pictures]), [[null, 40], [null, 80], [null, 120]]);
});

test('who turns or goes too fast is told so, with the pictures, and not again at once', () => {
  for (const fast of [(s: number) => ({ pose: pose(0, 90 * s) }), (s: number) => ({ pose: pose(1.2 * s) })]) {
    const said = walk(new WalkCoach(), 0, 10, fast, () => 7);
    assert.deepEqual(said.map(([, news]) => news.advice), ['slower', 'slower']);
    assert.equal(said[0]?.[1].pictures, 7);
    assert.ok((said[1]?.[0] ?? 0) - (said[0]?.[0] ?? 0) >= kAgainMs);
  }
});

test('a glance to the side is not too fast', () => {
  assert.deepEqual(walk(new WalkCoach(), 0, 5, (s) => ({ pose: pose(0, s > 2 && s < 2.5 ? 90 * (s - 2) : 0) })), []);
});

test('a phone that lost its way is told of once it lasted, and when it is found', () => {
  const coach = new WalkCoach();
  const lost = walk(coach, 0, 4, () => ({ pose: null }));
  assert.deepEqual(lost.map(([t, news]) => [t >= kLastsMs.lost, news.advice]), [[true, 'lost']]);
  const found = walk(coach, 4000, 3, () => ({}));
  assert.deepEqual(found.map(([, news]) => [news.advice, news.isBetter]), [[null, true]]);
});

test('missing depth and a phone that is held another way have words of their own', () => {
  assert.equal(walk(new WalkCoach(), 0, 4, () => ({ hasDepth: false }))[0]?.[1].advice, 'no_depth');
  assert.equal(walk(new WalkCoach(), 0, 2, () => ({ isTurned: true }))[0]?.[1].advice, 'turned');
});
