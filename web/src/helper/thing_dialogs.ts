// Correcting and removing a thing.
import { request } from '../shared/api';
import { textField } from '../shared/forms';
import type { Thing } from '../shared/protocol';
import { text } from '../shared/texts';
import { act, type Helper } from './actions';
import { openFormDialog, required } from '../shared/form_dialog';

export function correctThing(helper: Helper, thing: Thing): void {
  const name = textField(text('thing.name'), { value: thing.name, attributes: { maxlength: 60 } });
  openFormDialog({
    title: text('thing.correct_title', { thing: thing.name }),
    fields: [name],
    submit: text('dialog.save'),
    check: () => required(name, text('thing.name_missing')),
    run: () => act(helper, async () => {
      await request('PUT', `/api/things/${thing.id}`, { name: name.value() });
      await helper.store.refreshHome();
    }, text('thing.saved', { thing: name.value() })),
  });
}

export function removeThing(helper: Helper, thing: Thing): void {
  openFormDialog({
    title: text('thing.remove_title', { thing: thing.name }),
    explain: text('thing.remove_explain'),
    fields: [],
    submit: text('thing.remove'),
    dangerous: true,
    run: () => act(helper, async () => {
      await request('DELETE', `/api/things/${thing.id}`);
      await helper.store.refreshHome();
    }, text('thing.removed', { thing: thing.name })),
  });
}
