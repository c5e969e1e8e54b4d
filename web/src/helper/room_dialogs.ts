// Renaming, typing and deleting a room.
import { request } from '../shared/api';
import { h, newId } from '../shared/dom';
import { textField } from '../shared/forms';
import type { Home, Room } from '../shared/protocol';
import { text } from '../shared/texts';
import { act, type Helper } from './actions';
import { openFormDialog, required, type FormDialog } from '../shared/form_dialog';

// A dialog about a room; closes where somebody else renames or removes that meanwhile, since nothing would come of it.
export function openRoomDialog(helper: Helper, room: string, options: FormDialog): void {
  let isOurs = false; // the change that is made now
  let unwatch = (): void => undefined;
  const run = async (): Promise<() => void> => {
    isOurs = true;
    try {
      return await options.run();
    } finally {
      isOurs = false;
    }
  };
  const dialog = openFormDialog({ ...options, run }, () => unwatch());
  unwatch = helper.store.watch(['home'], () => {
    const { home } = helper.store.state;
    if (!isOurs && dialog.element.isConnected && home && !home.rooms.some(({ name }) => name === room)) {
      dialog.close();
      helper.announcer.say(text('room.is_gone', { room }), 'failed');
    }
  });
}

export function editRoom(helper: Helper, home: Home, room: Room): void {
  const opener = document.activeElement;
  const name = textField(text('room.name'), { value: room.name, attributes: { maxlength: 60 } });
  // Any word is a type; those that are known are offered.
  const types = h('datalist', { id: newId('types') }, ...home.room_types.map((one) => h('option', { value: one })));
  const type = textField(text('room.type'), {
    value: room.type ?? '', hint: text('room.type_hint'), attributes: { maxlength: 60, list: types.id },
  });
  openRoomDialog(helper, room.name, {
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
        callAnew(opener, room.name, name.value());
        await helper.store.refreshHome();
      }, text('room.saved', { room: name.value() }));
    },
  });
}

export function removeRoom(helper: Helper, room: Room): void {
  openRoomDialog(helper, room.name, {
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

// What opened the dialog is drawn anew under the new name, where the focus goes back to it.
function callAnew(opener: Element | null, old: string, now: string): void {
  const key = opener instanceof HTMLElement ? opener.dataset['key'] : undefined;
  if (key?.endsWith(` ${old}`)) {
    (opener as HTMLElement).dataset['key'] = key.slice(0, -old.length) + now;
  }
}
