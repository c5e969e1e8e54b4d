// What can be done to a thing on the plan or in the list, and things that are added.
import { openDialog } from '../../shared/dialog';
import { h } from '../../shared/dom';
import { selectField, textField, type Field } from '../../shared/forms';
import type { Home, Plan, Point, Thing } from '../../shared/protocol';
import { text } from '../../shared/texts';
import type { Helper } from '../actions';
import { openFormDialog, required } from '../../shared/form_dialog';
import { correctThing, removeThing } from '../thing_dialogs';
import { makeEdit } from './edits';
import { pointPicker, type PointPicker } from './point_picker';

// A choice of actions, each of which opens its own dialog.
export function openActions(title: string, actions: readonly [string, () => void][]): void {
  const dialog = openDialog(title, [h('div', { class: 'form' }, ...actions.map(([label, run]) =>
    h('button', { type: 'button', onclick: () => {
      dialog.close();
      run();
    } }, label)))]);
}

export function openThingActions(helper: Helper, thing: Thing): void {
  openActions(text('thing.actions_title', { thing: thing.name }), [
    [text('thing.correct'), () => correctThing(helper, thing)],
    [text('thing.note'), () => noteThing(helper, thing)],
    [text('thing.move'), () => moveThing(helper, thing)],
    [text('thing.merge'), () => mergeThing(helper, thing)],
    [text('thing.remove'), () => removeThing(helper, thing)],
  ]);
}

export function noteThing(helper: Helper, thing: Thing): void {
  const note = textField(text('thing.note_label'), { value: thing.note, hint: text('thing.note_hint'), attributes: { maxlength: 200 } });
  openFormDialog({
    title: text('thing.note_title', { thing: thing.name }),
    fields: [note],
    submit: text('dialog.save'),
    run: () => makeEdit(helper, { what: 'note', thing: thing.id, note: note.value() }, text('thing.note_saved', { thing: thing.name })),
  });
}

// The room, or a place on the plan where there is one.
interface PlaceFields {
  fields: Field[];
  extra: HTMLElement[];
  place: () => Record<string, unknown>;
}

function placeFields(helper: Helper, start: Thing | null): PlaceFields {
  const { home, plan } = helper.store.state;
  const rooms = [...(home?.rooms ?? [])].map(({ name }) => name).sort((a, b) => a.localeCompare(b));
  const room = selectField(text('thing.room'), rooms.map((name) => ({ value: name, label: name })), { value: start?.room ?? rooms[0] ?? '' });
  const picker = planPicker(home, plan, text('thing.where_on_plan'), start?.position ? [start.position[0], start.position[1]] : null);
  return {
    fields: [room],
    extra: picker ? [picker.element] : [],
    place: () => {
      const [point] = picker?.points() ?? [];
      return point ? { position: point } : { room: room.value() };
    },
  };
}

function planPicker(home: Home | null, plan: Plan, label: string, start: Point | null): PointPicker | null {
  return home && plan.rooms.length > 0 ? pointPicker(plan, home, { label, most: 1, start }) : null;
}

export function moveThing(helper: Helper, thing: Thing): void {
  const { fields, extra, place } = placeFields(helper, thing);
  openFormDialog({
    title: text('thing.move_title', { thing: thing.name }),
    fields, extra,
    submit: text('dialog.save'),
    run: () => makeEdit(helper, { what: 'move thing', thing: thing.id, ...place() }, text('thing.moved', { thing: thing.name })),
  });
}

export function mergeThing(helper: Helper, thing: Thing): void {
  const others = (helper.store.state.home?.things ?? []).filter(({ id }) => id !== thing.id);
  // Those of its room first: a double is near.
  others.sort((a, b) => Number(b.room === thing.room) - Number(a.room === thing.room) || a.name.localeCompare(b.name));
  const choices = others.map(({ id, name, room }) => ({ value: String(id), label: room === null ? name : `${name}, ${room}` }));
  const double = selectField(text('thing.double'), choices);
  openFormDialog({
    title: text('thing.merge_title', { thing: thing.name }),
    explain: text('thing.merge_explain', { thing: thing.name }),
    fields: [double],
    submit: text('thing.merge_go'),
    check: () => required(double, text('thing.no_double')),
    run: () => makeEdit(helper, { what: 'merge things', thing: thing.id, double: Number(double.value()) }, text('thing.merged', { thing: thing.name })),
  });
}

export function addThing(helper: Helper): void {
  const name = textField(text('thing.name'), { hint: text('thing.add_hint'), attributes: { maxlength: 60 } });
  const note = textField(text('thing.note_label'), { hint: text('thing.note_hint'), attributes: { maxlength: 200 } });
  const { fields, extra, place } = placeFields(helper, null);
  openFormDialog({
    title: text('plan.add_thing'),
    fields: [name, note, ...fields], extra,
    submit: text('thing.add_go'),
    check: () => required(name, text('thing.name_missing')),
    run: () => makeEdit(helper, { what: 'add thing', name: name.value(), note: note.value(), ...place() }, text('thing.added', { thing: name.value() })),
  });
}

export function addWayOut(helper: Helper): void {
  const { fields, extra, place } = placeFields(helper, null);
  openFormDialog({
    title: text('plan.add_way_out'),
    explain: text('plan.way_out_explain'),
    fields, extra,
    submit: text('thing.add_go'),
    run: () => makeEdit(helper, { what: 'add thing', name: 'way out', ...place() }, text('plan.way_out_added')),
  });
}
