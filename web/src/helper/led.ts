// A walk on which somebody is led, in words. Pure.
import type { Plan, WatchedWalk } from '../shared/protocol';
import { formatNumber, text } from '../shared/texts';
import { roomAt } from './plan/plan_geometry';
import type { Watched } from './store';

export const kFresh_ms = 2000; // a place of before is where they were

// How old the place is, by this page's clock; null: none is known.
export function placeAge(watched: Watched, now: number): number | null {
  const person = watched.walk?.person;
  return person ? watched.t - person.t + (now - watched.received) : null;
}

export function isStale(watched: Watched, now: number): boolean {
  return (placeAge(watched, now) ?? 0) > kFresh_ms;
}

// All that the drawing shows.
export function ledWords(watched: Watched, walk: WatchedWalk, plan: Plan, now: number): string {
  const { person, left_m, goal, state } = walk;
  const room = person ? roomAt(plan, [person.x, person.y]) ?? text('led.no_room') : text('led.no_place');
  const age = placeAge(watched, now);
  return [
    room,
    text('led.goal', { goal }),
    left_m === null ? '' : text('led.left', { metres: formatNumber(left_m, 1) }),
    text(`led.state_${state}`),
    age !== null && isStale(watched, now) ? text('led.age', { seconds: formatNumber(Math.floor(age / 1000)) }) : '',
  ].filter((part) => part !== '').join(' · ');
}

// By the clock on the wall.
export function saidAt(watched: Watched, t: number, now: number): string {
  const ago = watched.t - t + (now - watched.received);
  return new Date(Date.now() - ago).toLocaleTimeString(document.documentElement.lang);
}
