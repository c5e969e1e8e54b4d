// What can be done to a room on the plan or in the list, and rooms that are drawn.
import { selectField, textField } from '../../shared/forms';
import type { Home, Room } from '../../shared/protocol';
import { text } from '../../shared/texts';
import type { Helper } from '../actions';
import { openFormDialog, required } from '../../shared/form_dialog';
import { editRoom, openRoomDialog, removeRoom } from '../room_dialogs';
import { makeEdit } from './edits';
import { lineWithLeft } from './plan_geometry';
import { pointPicker } from './point_picker';
import { openActions } from './thing_actions';

const kMostCorners = 100;

export function openRoomActions(helper: Helper, home: Home, room: Room): void {
  const { plan } = helper.store.state;
  const isDrawn = plan.rooms.some(({ name }) => name === room.name);
  const hasOthers = home.rooms.length > 1;
  openActions(text('room.actions_title', { room: room.name }), [
    [text('room.edit'), () => editRoom(helper, home, room)],
    ...(isDrawn ? [[text('room.divide'), () => divideRoom(helper, home, room)] as [string, () => void]] : []),
    ...(hasOthers ? [[text('room.join'), () => joinRoom(helper, home, room)] as [string, () => void]] : []),
    ...(isDrawn && hasOthers ? [
      [text('room.border'), () => moveBorder(helper, home, room)] as [string, () => void],
      [text('room.add_door'), () => addDoor(helper, home, room)] as [string, () => void]] : []),
    ...(isDrawn ? [[text('room.draw'), () => drawRoom(helper, home, room.name)] as [string, () => void]] : []),
    [text('room.delete'), () => removeRoom(helper, room)],
  ]);
}

const otherRooms = (helper: Helper, home: Home, room: Room): { value: string; label: string }[] => {
  const neighbours = new Set(helper.store.state.plan.doors.filter(({ rooms }) => rooms.includes(room.name)).flatMap(({ rooms }) => rooms));
  return home.rooms.map(({ name }) => name).filter((name) => name !== room.name)
    .sort((a, b) => Number(neighbours.has(b)) - Number(neighbours.has(a)) || a.localeCompare(b))
    .map((name) => ({ value: name, label: name }));
};

function joinRoom(helper: Helper, home: Home, room: Room): void {
  const other = selectField(text('room.join_with'), otherRooms(helper, home, room));
  openRoomDialog(helper, room.name, {
    title: text('room.join_title', { room: room.name }),
    explain: text('room.join_explain', { room: room.name }),
    fields: [other],
    submit: text('room.join_go'),
    run: () => makeEdit(helper, { what: 'join rooms', room: room.name, other_room: other.value() }, text('room.joined', { room: room.name, other: other.value() })),
  });
}

function divideRoom(helper: Helper, home: Home, room: Room): void {
  const name = textField(text('room.new_name'), { hint: text('room.divide_hint'), attributes: { maxlength: 60 } });
  const line = pointPicker(helper.store.state.plan, home, { label: text('room.divide_line'), most: 3, shape: 'line', start: room.middle });
  openRoomDialog(helper, room.name, {
    title: text('room.divide_title', { room: room.name }),
    explain: text('room.divide_explain'),
    fields: [name], extra: [line.element],
    submit: text('room.divide_go'),
    check: () => required(name, text('room.name_missing')) && hasPoints(name, line.points().length, 3, text('room.line_missing')),
    run: () => makeEdit(helper, { what: 'divide room', room: room.name, other_room: name.value(), line: lineWithLeft(line.points()) }, text('room.divided', { room: room.name, other: name.value() })),
  });
}

function moveBorder(helper: Helper, home: Home, room: Room): void {
  const other = selectField(text('room.border_with'), otherRooms(helper, home, room));
  const line = pointPicker(helper.store.state.plan, home, { label: text('room.border_line', { room: room.name }), most: 3, shape: 'line', start: room.middle });
  openRoomDialog(helper, room.name, {
    title: text('room.border_title', { room: room.name }),
    explain: text('room.border_explain', { room: room.name }),
    fields: [other], extra: [line.element],
    submit: text('dialog.save'),
    check: () => hasPoints(other, line.points().length, 3, text('room.line_missing')),
    run: () => makeEdit(helper, { what: 'move border', room: room.name, other_room: other.value(), line: lineWithLeft(line.points()) }, text('room.border_moved', { room: room.name, other: other.value() })),
  });
}

function addDoor(helper: Helper, home: Home, room: Room): void {
  const other = selectField(text('room.door_to'), otherRooms(helper, home, room));
  const at = pointPicker(helper.store.state.plan, home, { label: text('room.door_where'), most: 1, start: room.middle });
  openRoomDialog(helper, room.name, {
    title: text('room.door_title', { room: room.name }),
    fields: [other], extra: [at.element],
    submit: text('thing.add_go'),
    check: () => hasPoints(other, at.points().length, 1, text('room.door_missing')),
    run: () => makeEdit(helper, { what: 'add door', room: room.name, other_room: other.value(), position: at.points()[0] }, text('room.door_added', { room: room.name, other: other.value() })),
  });
}

export function drawNewRoom(helper: Helper): void {
  const { home } = helper.store.state;
  if (home) {
    drawRoom(helper, home, '');
  }
}

function drawRoom(helper: Helper, home: Home, room: string): void {
  const name = textField(text('room.name'), { value: room, attributes: { maxlength: 60 } });
  const outline = pointPicker(helper.store.state.plan, home, { label: text('room.outline'), most: kMostCorners, shape: 'outline' });
  const dialog = {
    title: room === '' ? text('plan.draw_room') : text('room.draw_title', { room }),
    explain: text('room.draw_explain'),
    fields: [name], extra: [outline.element],
    submit: text('dialog.save'),
    check: () => required(name, text('room.name_missing')) && hasPoints(name, outline.points().length, 3, text('room.corners_missing')),
    run: () => makeEdit(helper, { what: 'draw room', room: name.value(), outline: outline.points() }, text('room.drawn', { room: name.value() })),
  };
  if (room === '') {
    openFormDialog(dialog);
  } else {
    openRoomDialog(helper, room, dialog);
  }
}

function hasPoints(field: { fail: (message: string) => void }, count: number, wanted: number, missing: string): boolean {
  if (count >= wanted) {
    return true;
  }
  field.fail(missing);
  return false;
}
