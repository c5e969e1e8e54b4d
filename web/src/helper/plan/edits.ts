// What helpers changed: in words, made and undone.
import { request } from '../../shared/api';
import type { Edit } from '../../shared/protocol';
import { text, type TextKey } from '../../shared/texts';
import { act, actAndSay, type Helper } from '../actions';

// Makes a change, and gives what says that it is done.
export function makeEdit(helper: Helper, edit: Record<string, unknown>, done: string): Promise<() => void> {
  return act(helper, async () => {
    await request('POST', '/api/edits', edit);
    await helper.store.refreshHome();
  }, done);
}

export function undoEdit(helper: Helper, edit: Edit): Promise<void> {
  return actAndSay(helper, async () => {
    await request('DELETE', `/api/edits/${edit.edit}`);
    await helper.store.refreshHome();
  }, text('edits.undone', { what: editWords(edit) }));
}

const kWords: Record<Edit['what'], TextKey> = {
  'add thing': 'edits.add_thing',
  'rename thing': 'edits.rename_thing',
  note: 'edits.note',
  'move thing': 'edits.move_thing',
  'merge things': 'edits.merge_things',
  'remove thing': 'edits.remove_thing',
  'rename room': 'edits.rename_room',
  'room type': 'edits.room_type',
  'name frames': 'edits.name_frames',
  'remove room': 'edits.remove_room',
  'take walk away': 'edits.take_walk_away',
  'join rooms': 'edits.join_rooms',
  'divide room': 'edits.divide_room',
  'move border': 'edits.move_border',
  'draw room': 'edits.draw_room',
  'add door': 'edits.add_door',
};

// "renamed cup to mug".
export function editWords(edit: Edit): string {
  const { name, old_name, note, room, other_room, type } = edit;
  const values = { name, old: old_name, note, room, other: other_room, type };
  if (edit.what === 'note' && note === '') {
    return text('edits.no_note', values);
  }
  if (edit.what === 'move thing' && room !== '') {
    return text('edits.move_to_room', values);
  }
  return text(kWords[edit.what], values);
}
