// The plan of the home with its legend and what can be done to the home as a whole. All that the drawing shows and
// offers is in the list beside it, too.
import { h, replaceChildren } from '../../shared/dom';
import { counted, formatNumber, text } from '../../shared/texts';
import type { Helper } from '../actions';
import { rerender } from '../rerender';
import { openRoomActions } from './room_actions';
import { addThing, addWayOut, openThingActions } from './thing_actions';
import { drawNewRoom } from './room_actions';
import { drawPlan, svg, toneOf } from './plan_drawing';

export function planView(helper: Helper): HTMLElement {
  const { store } = helper;
  const stage = h('div', { class: 'plan-stage' });
  const legend = h('div');
  const actions = h('div', { class: 'row tight', role: 'group', 'aria-label': text('plan.actions') });
  const element = h('section', { class: 'plan-part', 'aria-label': text('plan.heading') },
    h('h3', {}, text('plan.heading')), stage, legend, actions);
  store.watch(['home'], () => {
    const { home, plan } = store.state;
    element.hidden = !home || home.recordings.length === 0;
    if (!home || element.hidden) {
      return;
    }
    if (plan.rooms.length === 0) {
      replaceChildren(stage, h('p', { class: 'hint' }, text('plan.none')));
      replaceChildren(legend);
    } else {
      const label = text('plan.label', { rooms: counted('home.rooms', plan.rooms.length), things: counted('home.things', home.things.length) });
      const drawing = drawPlan(plan, home, label);
      drawing.element.addEventListener('click', (event) => chosen(helper, event));
      replaceChildren(stage, drawing.element);
      replaceChildren(legend, legendOf(helper));
    }
    rerender(actions, [
      action('plan.add_thing', () => addThing(helper)),
      action('plan.add_way_out', () => addWayOut(helper)),
      ...(plan.rooms.length > 0 ? [action('plan.draw_room', () => drawNewRoom(helper)),
        action('plan.print', () => window.print())] : []),
    ]);
  });
  return element;
}

function action(key: 'plan.add_thing' | 'plan.add_way_out' | 'plan.draw_room' | 'plan.print', run: () => void): HTMLElement {
  return h('button', { type: 'button', class: 'small', 'data-key': key, onclick: run }, text(key));
}

// Who taps a thing or a room gets what can be done to it, as by its button in the list.
function chosen(helper: Helper, event: Event): void {
  const target = event.target as Element;
  const { home } = helper.store.state;
  const thing = target.closest('[data-thing]')?.getAttribute('data-thing');
  const room = target.closest('[data-room]')?.getAttribute('data-room');
  const known = home?.things.find((one) => String(one.id) === thing);
  const knownRoom = home?.rooms.find((one) => one.name === room);
  if (known) {
    openThingActions(helper, known);
  } else if (home && knownRoom) {
    openRoomActions(helper, home, knownRoom);
  }
}

function legendOf(helper: Helper): HTMLElement {
  const { home, plan } = helper.store.state;
  const entry = (mark: Node, words: string): HTMLElement => h('li', {}, mark, h('span', {}, words));
  const sign = (...parts: Node[]): SVGElement => svg('svg', { viewBox: '-0.2 -0.2 0.4 0.4', class: 'plan sign', 'aria-hidden': 'true' }, ...parts);
  const area = (name: string): string => {
    const floor = home?.rooms.find((room) => room.name === name)?.floor_m2;
    return floor ? `${name}, ${text('home.floor', { area: formatNumber(floor, 1) })}` : name;
  };
  return h('ul', { class: 'legend', 'aria-label': text('plan.legend') },
    ...plan.rooms.map(({ name }) => entry(
      sign(svg('rect', { x: -0.19, y: -0.19, width: 0.38, height: 0.38, class: `floor tone-${toneOf(plan, name)}` })), area(name))),
    entry(sign(svg('g', { class: 'door' }, svg('circle', { r: 0.15 }), svg('path', { d: 'M-0.08 0H0.08' }))), text('plan.a_door')),
    entry(sign(svg('g', { class: 'mark' }, svg('circle', { r: 0.11 }))), text('plan.a_thing')),
    entry(sign(svg('g', { class: 'mark added' }, svg('path', { d: 'M0 -0.16L0.16 0L0 0.16L-0.16 0Z' }))), text('plan.an_added_thing')));
}
