// What is forgotten and still in the home's file: when it goes, a way back, and a way to have it go at once.
import { request } from '../shared/api';
import { h } from '../shared/dom';
import { text } from '../shared/texts';
import { act, actOrSay, type Helper } from './actions';
import { openFormDialog } from '../shared/form_dialog';
import { rerender, showPart } from './rerender';
import { card } from './shell';

export function eraseCard(helper: Helper): HTMLElement {
  const when = h('p', {}, text('erase.when'));
  const owed = h('p', { role: 'status' });
  const list = h('ul', { class: 'ranges' });
  const now = h('button', { type: 'button', class: 'danger', onclick: () => eraseNow(helper) }, text('erase.now'));
  const element = card(text('erase.heading'), owed, when, list, h('div', { class: 'row' }, now));
  helper.store.watch(['home'], () => {
    const { walks, rooms, owed: isOwed } = helper.store.state.home?.to_erase ?? { walks: [], rooms: [], owed: false };
    const waiting = [
      ...walks.map(({ name, edit }) => ({ what: text('erase.walk', { name }), edit })),
      ...rooms.map(({ name, edit }) => ({ what: text('erase.room', { name }), edit })),
    ];
    showPart(element, waiting.length > 0 || isOwed);
    when.hidden = waiting.length === 0;
    owed.hidden = !isOwed;
    owed.textContent = isOwed ? text('erase.owed') : '';
    rerender(list, waiting.map(({ what, edit }) => h('li', {}, h('span', {}, what), backButton(helper, what, edit))));
  });
  return element;
}

function backButton(helper: Helper, what: string, edit: number): HTMLElement {
  const run = (): void => actOrSay(helper, async () => {
    await request('DELETE', `/api/edits/${edit}`);
    await helper.store.refreshHome();
  }, text('erase.back_done', { what }));
  return h('button', { type: 'button', class: 'small', 'data-key': `back ${edit}`, 'aria-label': `${text('erase.back')}: ${what}`, onclick: run }, text('erase.back'));
}

function eraseNow(helper: Helper): void {
  openFormDialog({
    title: text('erase.now_title'),
    explain: text('erase.now_explain'),
    fields: [],
    submit: text('erase.now'),
    dangerous: true,
    run: () => act(helper, async () => {
      await request('POST', '/api/erase');
      await helper.store.refreshHome();
    }, text('erase.done')),
  });
}
