// The way from an empty home to one that answers: which steps are done, which comes next.
import { h, replaceChildren } from '../shared/dom';
import { icon } from '../shared/icons';
import { text, type TextKey } from '../shared/texts';
import type { Helper } from './actions';
import type { HelperState } from './store';

export interface Step {
  key: 'pair' | 'record' | 'name' | 'learn' | 'try';
  part: string; // of the page, where it is done
  done: boolean;
}

export function firstSteps({ devices, home, recognitions }: Pick<HelperState, 'devices' | 'home' | 'recognitions'>): Step[] {
  const walks = home?.recordings ?? [];
  const learned = home !== null && home.learned !== null;
  return [
    { key: 'pair', part: 'devices', done: devices.some(({ role }) => role === 'device') },
    // Rooms can be learned from photos alone.
    { key: 'record', part: 'walks', done: learned || walks.length > 0 },
    { key: 'name', part: 'walks', done: learned || walks.some(({ ranges }) => ranges.length > 0) },
    { key: 'learn', part: 'recognise', done: learned },
    { key: 'try', part: 'recognise', done: recognitions.length > 0 },
  ];
}

const kWords: Record<Step['key'], TextKey> = {
  pair: 'steps.pair', record: 'steps.record', name: 'steps.name', learn: 'steps.learn', try: 'steps.try',
};

// Shown until all is done.
export function firstStepsView({ store }: Helper): HTMLElement {
  const list = h('ol', { class: 'steps' });
  const element = h('section', { class: 'card', 'aria-label': text('steps.heading') }, h('h3', {}, text('steps.heading')), list);
  store.watch(['home', 'devices', 'recognitions'], () => {
    const steps = firstSteps(store.state);
    const next = steps.findIndex(({ done }) => !done);
    element.hidden = store.state.home === null || next < 0;
    replaceChildren(list, ...steps.map(({ key, part, done }, i) => h('li', { 'aria-current': i === next ? 'step' : null },
      done ? icon('tick') : h('span', { class: 'step-number', 'aria-hidden': 'true' }, String(i + 1)),
      h('span', {}, done ? text(kWords[key]) : h('a', { href: `#${part}` }, text(kWords[key])),
        done ? h('span', { class: 'hint' }, ` ${text('steps.done')}`) : null,
        i === next ? h('span', { class: 'hint' }, ` ${text('steps.next')}`) : null))));
  });
  return element;
}
