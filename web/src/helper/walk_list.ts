// All walks: when they were recorded, in which colour their way is drawn, and what can be done to each.
import { request } from '../shared/api';
import { h, type Child } from '../shared/dom';
import type { Recording } from '../shared/protocol';
import { svg } from '../shared/svg';
import { counted, formatTime, text } from '../shared/texts';
import { kWalkColours } from '../view3d/walk_colours';
import { act, actOrSay, type Helper } from './actions';
import { openFormDialog } from './form_dialog';
import { rerender } from './rerender';
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
  store.watch(['home', 'job', 'recording'], () => {
    const { home, keyframes, job, recording } = store.state;
    const walks = home?.recordings ?? [];
    const isStopped = job?.kind === 'map' && (job.state === 'stopped' || job.state === 'failed');
    const isBusy = job?.state === 'running' || recording?.state === 'recording';
    row.hidden = isBusy || !(isStopped || walks.some(({ finished }) => !finished));
    element.hidden = walks.length === 0 && row.hidden;
    const isReady = keyframes.length > 0;
    rerender(list, walks.map((walk, i) => h('li', {}, ...walkView(helper, walk, i, isReady && !keyframes.some((one) => one.recording === walk.id)))));
  });
  return element;
}

function walkView(helper: Helper, walk: Recording, place: number, isApart: boolean): Child[] {
  const facts = [
    walk.recorded === null ? '' : text('walks.recorded', { when: formatTime(walk.recorded) }),
    counted('home.frames', walk.frames),
    walk.finished ? '' : text('walks.unfinished'),
    walk.finished && isApart ? text('walks.apart') : '',
  ].filter((fact) => fact !== '');
  return [
    h('span', { class: 'pictured' }, swatch(place), h('span', {}, walk.name, h('span', { class: 'hint facts' }, facts.join(' · ')))),
    h('button', {
      type: 'button', class: 'small', 'data-key': `forget ${walk.id}`, 'aria-label': `${text('walks.forget')} ${walk.name}`,
      onclick: () => forget(helper, walk),
    }, text('walks.forget')),
  ];
}

// As its way is drawn in the view in three dimensions.
function swatch(place: number): Element {
  const line = svg('path', { d: 'M2 12H22', 'stroke-width': 5, 'stroke-linecap': 'round', stroke: kWalkColours[place % kWalkColours.length] as string });
  return svg('svg', { viewBox: '0 0 24 24', class: 'swatch', 'aria-hidden': 'true' }, line);
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
