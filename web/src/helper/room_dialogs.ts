// Renaming, typing and deleting a room.
import { request } from '../shared/api';
import { h, newId } from '../shared/dom';
import { textField } from '../shared/forms';
import type { Home, Room } from '../shared/protocol';
import { text } from '../shared/texts';
import { act, type Helper } from './actions';
import { openFormDialog, required } from '../shared/form_dialog';

export function editRoom(helper: Helper, home: Home, room: Room): void {
  const name = textField(text('room.name'), { value: room.name, attributes: { maxlength: 60 } });
  // Any word is a type; those that are known are offered.
  const types = h('datalist', { id: newId('types') }, ...home.room_types.map((one) => h('option', { value: one })));
  const type = textField(text('room.type'), {
    value: room.type ?? '', hint: text('room.type_hint'), attributes: { maxlength: 60, list: types.id },
  });
  openFormDialog({
    title: text('room.edit_title', { room: room.name }),
    fields: [name, type], extra: [types],
    submit: text('dialog.save'),
    check: () => required(name, text('room.name_missing')),
    run: () => {
      const change = {
        ...(name.value() !== room.name ? { name: name.value() } : {}),
        ...(type.value() !== (room.type ?? '') && type.value() !== '' ? { type: type.value() } : {}),
      };
      return act(helper, async () => {
        await request('PUT', `/api/rooms/${encodeURIComponent(room.name)}`, change);
        await helper.store.refreshHome();
      }, text('room.saved', { room: name.value() }));
    },
  });
}

export function removeRoom(helper: Helper, room: Room): void {
  openFormDialog({
    title: text('room.delete_title', { room: room.name }),
    explain: text('room.delete_explain'),
    fields: [],
    submit: text('room.delete'),
    dangerous: true,
    run: () => act(helper, async () => {
      await request('DELETE', `/api/rooms/${encodeURIComponent(room.name)}`);
      await helper.store.refreshHome();
    }, text('room.deleted', { room: room.name })),
  });
}
