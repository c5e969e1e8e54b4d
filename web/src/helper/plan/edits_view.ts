// The newest change with its undo, and all that were made.
import { h, type Child } from '../../shared/dom';
import type { Edit } from '../../shared/protocol';
import { language, text } from '../../shared/texts';
import type { Helper } from '../actions';
import { rerender, showPart } from '../rerender';
import { editWords, undoEdit } from './edits';

export function editsView(helper: Helper): HTMLElement {
  const newest = h('div', { class: 'row' });
  const list = h('ul', { class: 'plain edits' });
  const all = h('details', {}, h('summary', {}, text('edits.all')), list);
  const element = h('section', { class: 'edits-part', 'aria-label': text('edits.heading') }, newest, all);
  helper.store.watch(['home'], () => {
    const { edits } = helper.store.state;
    const last = edits.find((edit) => edit.undo_first === '');
    showPart(element, edits.length > 0);
    rerender(newest, last ? [undoButton(helper, last, text('edits.undo_what', { what: editWords(last) }), 'undo newest')] : []);
    rerender(list, edits.map((edit) => h('li', {}, ...entry(helper, edit))));
  });
  return element;
}

function entry(helper: Helper, edit: Edit): Child[] {
  const when = new Intl.DateTimeFormat(language(), { dateStyle: 'medium', timeStyle: 'short' }).format(edit.made * 1000);
  const words = editWords(edit);
  return [
    h('span', {}, words, h('span', { class: 'hint' }, ` ${edit.by === '' ? when : text('edits.by', { by: edit.by, when })}`)),
    edit.without_effect !== '' ? h('p', { class: 'hint' }, text('edits.without_effect')) : null,
    edit.undo_first !== ''
      ? h('p', { class: 'hint' }, text(edit.is_final ? 'edits.is_final' : 'edits.undo_later_first'))
      : undoButton(helper, edit, text('edits.undo'), `undo ${edit.edit}`, text('edits.undo_what', { what: words })),
  ];
}

function undoButton(helper: Helper, edit: Edit, label: string, key: string, name = label): HTMLElement {
  const run = (): void => {
    undoEdit(helper, edit).catch(async (error: unknown) => {
      await helper.store.refreshHome().catch(() => undefined); // another helper changed something meanwhile
      helper.announcer.say(error, 'failed');
    });
  };
  return h('button', { type: 'button', class: 'small', 'data-key': key, 'aria-label': name, onclick: run }, label);
}
