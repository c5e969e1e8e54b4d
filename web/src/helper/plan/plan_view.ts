// The plan of the home with its legend and what can be done to the home as a whole. All that the drawing shows and
// offers is in the list beside it, too.
import { h, replaceChildren } from '../../shared/dom';
import { svg } from '../../shared/svg';
import { counted, formatNumber, text } from '../../shared/texts';
import type { Helper } from '../actions';
import { radioField } from '../../shared/forms';
import type { Home, Plan, Stairs } from '../../shared/protocol';
import { onStorey } from '../../shared/storeys';
import { rerender } from '../rerender';
import { openRoomActions } from './room_actions';
import { addThing, addWayOut, openThingActions } from './thing_actions';
import { drawNewRoom } from './room_actions';
import { drawPlan, toneOf } from './plan_drawing';

export function planView(helper: Helper): HTMLElement {
  const { store } = helper;
  const stage = h('div', { class: 'plan-stage' });
  const storeys = h('div');
  let storey = 0; // that is shown
  const legend = h('div');
  const actions = h('div', { class: 'row tight', role: 'group', 'aria-label': text('plan.actions') });
  const element = h('section', { class: 'plan-part', 'aria-label': text('plan.heading') },
    h('h3', {}, text('plan.heading')), storeys, stage, legend, actions);
  const show = (): void => {
    const { home, plan } = store.state;
    element.hidden = !home || home.recordings.length === 0;
    if (!home || element.hidden) {
      return;
    }
    if (plan.rooms.length === 0) {
      replaceChildren(stage, h('p', { class: 'hint' }, text(home.recordings.some(({ ranges }) => ranges.length > 0) ? 'plan.waits' : 'plan.none')));
      replaceChildren(legend);
    } else {
      const label = text('plan.label', { rooms: counted('home.rooms', plan.rooms.length), things: counted('home.things', home.things.length) });
      storey = Math.min(storey, Math.max(0, (home.storeys?.length ?? 1) - 1));
      const shown = onStorey(plan, home, storey);
      const drawing = drawPlan(shown.plan, shown.home, label, plan);
      drawing.element.addEventListener('click', (event) => chosen(helper, event));
      replaceChildren(stage, drawing.element);
      replaceChildren(legend, legendOf(helper, shown.plan));
    }
    rerender(storeys, storeyChooser(plan, home, storey, (chosen) => {
      storey = chosen;
      show();
    }));
    rerender(actions, [
      action('plan.add_thing', () => addThing(helper)),
      action('plan.add_way_out', () => addWayOut(helper)),
      ...(plan.rooms.length > 0 ? [action('plan.draw_room', () => drawNewRoom(helper)),
        action('plan.print', () => window.print())] : []),
    ]);
  };
  store.watch(['home'], show);
  return element;
}

// Which storey is drawn: radio buttons, named by number and rooms, lowest first; of one storey nothing.
function storeyChooser(plan: Plan, home: Home, shown: number, choose: (storey: number) => void): HTMLElement[] {
  const count = home.storeys?.length ?? 1;
  if (count < 2) {
    return [];
  }
  const choices = Array.from({ length: count }, (_, i) => ({
    value: String(i),
    label: text('plan.storey', { number: i + 1, rooms: onStorey(plan, home, i).plan.rooms.map(({ name }) => name).join(', ') }),
  }));
  const field = radioField(text('plan.storeys'), choices, String(shown), (value) => choose(Number(value)));
  // The focus stays on what was chosen when the plan is drawn anew.
  field.querySelectorAll('input').forEach((input) => input.setAttribute('data-key', `storey-${input.value}`));
  return [field];
}

function stairsInWords({ rooms, steps, left_rail, right_rail }: Stairs): string {
  const [a, b] = rooms.map((room) => room ?? text('picker.no_room')) as [string, string];
  const rails = left_rail && right_rail ? 'plan.rails' : left_rail ? 'plan.rail_left' : right_rail ? 'plan.rail_right' : null;
  return [text('plan.stairs', { a, b }), ...(steps > 0 ? [counted('plan.steps', steps)] : []), ...(rails ? [text(rails)] : [])].join(', ');
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

function legendOf(helper: Helper, shown: Plan): HTMLElement {
  const { home, plan } = helper.store.state;
  const entry = (mark: Node, words: string): HTMLElement => h('li', {}, mark, h('span', {}, words));
  const sign = (...parts: Node[]): SVGElement => svg('svg', { viewBox: '-0.2 -0.2 0.4 0.4', class: 'plan sign', 'aria-hidden': 'true' }, ...parts);
  const area = (name: string): string => {
    const floor = home?.rooms.find((room) => room.name === name)?.floor_m2;
    return floor ? `${name}, ${text('home.floor', { area: formatNumber(floor, 1) })}` : name;
  };
  return h('ul', { class: 'legend', 'aria-label': text('plan.legend') },
    ...shown.rooms.map(({ name }) => entry(
      sign(svg('rect', { x: -0.19, y: -0.19, width: 0.38, height: 0.38, class: `floor tone-${toneOf(plan, name)}` })), area(name))),
    entry(sign(svg('g', { class: 'door' }, svg('circle', { r: 0.15 }), svg('path', { d: 'M-0.08 0H0.08' }))), text('plan.a_door')),
    entry(sign(svg('g', { class: 'mark' }, svg('circle', { r: 0.11 }))), text('plan.a_thing')),
    entry(sign(svg('g', { class: 'mark added' }, svg('path', { d: 'M0 -0.16L0.16 0L0 0.16L-0.16 0Z' }))), text('plan.an_added_thing')),
    ...(home?.stairs ?? []).map((stairs) => h('li', {}, stairsInWords(stairs))));
}
