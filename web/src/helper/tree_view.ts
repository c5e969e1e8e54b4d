// The home in words: headings and lists, with what can be done beside each.
import { openDialog } from '../shared/dialog';
import { h, type Child } from '../shared/dom';
import type { Home, Thing } from '../shared/protocol';
import { counted, formatNumber, formatPercent, text } from '../shared/texts';
import type { Helper } from './actions';
import type { Outline, RoomOutline } from './outline';
import { thingPicture } from './pictures';
import { openRoomActions } from './plan/room_actions';
import { openThingActions } from './plan/thing_actions';
import { editRoom, removeRoom } from './room_dialogs';
import { correctThing, removeThing } from './thing_dialogs';

export function outlineView(helper: Helper, home: Home, outline: Outline): Child[] {
  const { rooms, elsewhere, doorways, recordings } = outline;
  if (rooms.length + elsewhere.length + doorways.length + recordings.length === 0) {
    return [h('p', {}, text(home.rooms.length === 0 ? 'home.empty' : 'home.nothing_fits'))];
  }
  return [
    h('ul', { class: 'rooms' }, ...rooms.map((room) => h('li', { class: 'card room' }, ...roomView(helper, home, room)))),
    elsewhere.length > 0
      ? h('section', {}, h('h3', {}, text('home.elsewhere')), thingList(helper, elsewhere)) : null,
    doorways.length > 0
      ? h('section', {}, h('h3', {}, text('home.doorways')), h('ul', { class: 'plain' },
        ...doorways.map(({ rooms: between, door }) => h('li', {},
          door ? between.join(' – ') : text('home.open', { a: between[0] ?? '', b: between[1] ?? '' }))))) : null,
    recordings.length > 0
      ? h('section', {}, h('h3', {}, text('home.walks')), h('ul', { class: 'plain' },
        ...recordings.map((one) => h('li', {},
          `${one.name}: ${counted('home.frames', one.frames)}${one.finished ? '' : `, ${text('home.unfinished')}`}`)))) : null,
  ];
}

function roomView(helper: Helper, home: Home, { room, things, neighbours }: RoomOutline): Child[] {
  const facts = [
    room.type !== null && room.type !== room.name ? room.type : '',
    room.floor_m2 !== null ? text('home.floor', { area: formatNumber(room.floor_m2, 1) }) : '',
    neighbours.length > 0 ? text('home.leads_to', { rooms: neighbours.join(', ') }) : '',
  ].filter((fact) => fact !== '');
  return [
    h('div', { class: 'head' },
      h('h3', {}, room.name),
      h('div', { class: 'row tight' },
        action(`edit ${room.name}`, text('room.edit'), room.name, () => editRoom(helper, home, room)),
        action(`delete ${room.name}`, text('room.delete'), room.name, () => removeRoom(helper, room)),
        action(`more ${room.name}`, text('home.more'), room.name, () => openRoomActions(helper, home, room)))),
    facts.length > 0 ? h('p', { class: 'hint' }, facts.join(' · ')) : null,
    things.length > 0 ? thingList(helper, things) : h('p', { class: 'hint' }, text('home.no_things')),
  ];
}

function thingList(helper: Helper, things: readonly Thing[]): HTMLElement {
  return h('ul', { class: 'things' }, ...things.map((thing) => h('li', {},
    h('span', { class: 'thing' }, thing.name,
      h('span', { class: 'hint' }, ` ${thing.by_hand ? text('thing.by_hand') : formatPercent(thing.probability)}`),
      thing.note !== '' ? h('span', { class: 'note' }, thing.note) : null),
    h('div', { class: 'row tight' },
      thing.added ? null : action(`picture ${thing.id}`, text('thing.picture'), thing.name, () => {
        openDialog(thing.name, [thingPicture(thing)]);
      }),
      action(`correct ${thing.id}`, text('thing.correct'), thing.name, () => correctThing(helper, thing)),
      action(`remove ${thing.id}`, text('thing.remove'), thing.name, () => removeThing(helper, thing)),
      action(`more ${thing.id}`, text('home.more'), thing.name, () => openThingActions(helper, thing))))));
}

// A small button whose name says to what it belongs.
function action(key: string, label: string, of: string, run: () => void): HTMLElement {
  return h('button', { type: 'button', class: 'small', 'data-key': key, 'aria-label': `${label} ${of}`, onclick: run }, label);
}
