// What the newest walk found other than the walks before it.
import { h, replaceChildren } from '../shared/dom';
import type { Home, ThingChange } from '../shared/protocol';
import { formatNumber, text } from '../shared/texts';
import type { Helper } from './actions';
import { card } from './shell';

export function changesCard({ store }: Helper): HTMLElement {
  const place = h('div');
  const element = card(text('changes.heading'), place);
  store.watch(['home'], () => {
    const { home } = store.state;
    element.hidden = !home?.changes;
    if (home?.changes) {
      replaceChildren(place, h('p', {}, sinceWords(home)), list(home.changes.things));
    }
  });
  return element;
}

function list(things: readonly ThingChange[]): HTMLElement {
  return h('ul', { hidden: things.length === 0 }, ...things.map((one) => h('li', {}, changeWords(one))));
}

export function sinceWords({ changes, recordings }: Home): string {
  const name = (id: number | undefined): string => recordings.find((one) => one.id === id)?.name ?? '';
  const values = { walk: name(changes?.walk), since: name(changes?.since) };
  return text(changes?.things.length ? 'changes.since' : 'changes.nothing', values);
}

export function changeWords({ what, name, room, moved_m }: ThingChange): string {
  const words = moved_m === null
    ? text(`changes.${what}`, { thing: name })
    : text('changes.moved_by', { thing: name, metres: formatNumber(moved_m, 1) });
  return room === null ? words : text('changes.in_room', { words, room });
}
