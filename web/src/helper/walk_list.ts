// All walks: when they were recorded, in which colour their way is drawn, and what can be done to each.
import { request } from '../shared/api';
import { h, setText } from '../shared/dom';
import type { Recording } from '../shared/protocol';
import { svg } from '../shared/svg';
import { counted, formatTime, text } from '../shared/texts';
import { kWalkColours } from '../view3d/walk_colours';
import { act, actOrSay, type Helper } from './actions';
import { openFormDialog } from '../shared/form_dialog';
import { keptRows, type Row } from './rerender';
import { card } from './shell';

export function walkListCard(helper: Helper): HTMLElement {
  const { store } = helper;
  const list = h('ul', { class: 'ranges walks' });
  const goOn = h('button', {
    type: 'button',
    onclick: () => actOrSay(helper, () => request('POST', '/api/job/go_on'), text('walks.goes_on')),
  }, text('walks.go_on'));
  const row = h('div', { class: 'row' }, goOn);
  const element = card(text('walks.all'), list, row);
  const show = keptRows(list, ({ walk }: ListedWalk) => walk.id, (walk) => walkRow(helper, walk));
  store.watch(['home', 'job', 'recording'], () => {
    const { home, keyframes, job, recording } = store.state;
    const walks = home?.recordings ?? [];
    const isBusy = job?.state === 'running' || recording?.state === 'recording';
    row.hidden = isBusy || home?.walk_waits !== true;
    element.hidden = walks.length === 0 && row.hidden;
    const isReady = keyframes.length > 0;
    show(walks.map((walk) => ({ walk, isApart: isReady && !keyframes.some((one) => one.recording === walk.id) })));
  });
  return element;
}

interface ListedWalk {
  walk: Recording;
  isApart: boolean; // not on the map with the others
}

function walkRow(helper: Helper, { walk: first }: ListedWalk): Row<ListedWalk> {
  let walk = first;
  const line = svg('path', { d: 'M2 12H22', 'stroke-width': 5, 'stroke-linecap': 'round' }); // as its way is drawn in three dimensions
  const name = h('span');
  const facts = h('span', { class: 'hint facts' });
  const button = h('button', {
    type: 'button', class: 'small', 'data-key': `forget ${walk.id}`, onclick: () => forget(helper, walk),
  }, text('walks.forget'));
  return {
    element: h('li', {},
      h('span', { class: 'pictured' }, svg('svg', { viewBox: '0 0 24 24', class: 'swatch', 'aria-hidden': 'true' }, line), h('span', {}, name, facts)),
      button),
    show: (now, place) => {
      walk = now.walk;
      line.setAttribute('stroke', kWalkColours[place % kWalkColours.length] as string);
      setText(name, walk.name);
      setText(facts, factsOf(now));
      button.setAttribute('aria-label', `${text('walks.forget')} ${walk.name}`);
    },
  };
}

function factsOf({ walk, isApart }: ListedWalk): string {
  return [
    walk.recorded === null ? '' : text('walks.recorded', { when: formatTime(walk.recorded) }),
    counted('home.frames', walk.frames),
    walk.finished ? '' : text('walks.unfinished'),
    walk.finished && isApart ? text('walks.apart') : '',
  ].filter((fact) => fact !== '').join(' · ');
}

function forget(helper: Helper, { id, name }: Recording): void {
  openFormDialog({
    title: text('walks.forget_title', { name }),
    explain: text('forget.walk_explain'),
    fields: [],
    submit: text('walks.forget'),
    dangerous: true,
    run: () => act(helper, async () => {
      await takeWalkAway(id);
      await helper.store.refreshHome();
    }, text('forget.walk_done', { name })),
  });
}

// It can be taken back until it is erased.
export function takeWalkAway(walk: number): Promise<unknown> {
  return request('POST', '/api/edits', { what: 'take walk away', walk });
}
