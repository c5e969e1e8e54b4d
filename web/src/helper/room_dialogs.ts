// Renaming, typing and deleting a room.
import { request } from '../shared/api';
import { selectField, textField } from '../shared/forms';
import type { Home, Room } from '../shared/protocol';
import { text } from '../shared/texts';
import { act, type Helper } from './actions';
import { openFormDialog, required } from './form_dialog';

export function editRoom(helper: Helper, home: Home, room: Room): void {
  const name = textField(text('room.name'), { value: room.name, attributes: { maxlength: 60 } });
  // A type that is none of the home's own stays what it is.
  const types = room.type === null || home.room_types.includes(room.type) ? home.room_types : [room.type, ...home.room_types];
  const type = selectField(text('room.type'), [
    ...(room.type === null ? [{ value: '', label: text('room.no_type') }] : []),
    ...types.map((one) => ({ value: one, label: one })),
  ], { value: room.type ?? '' });
  openFormDialog({
    title: text('room.edit_title', { room: room.name }),
    fields: [name, type],
    submit: text('dialog.save'),
    check: () => required(name, text('room.name_missing')),
    run: async () => {
      const change = {
        ...(name.value() !== room.name ? { name: name.value() } : {}),
        ...(type.value() !== (room.type ?? '') ? { type: type.value() } : {}),
      };
      await act(helper, async () => {
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
