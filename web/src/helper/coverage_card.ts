// What the walks have not shown yet: a list by rooms, and the plan with its numbers.
import { ApiError, request, showWhy } from '../shared/api';
import { h, replaceChildren, type Child } from '../shared/dom';
import type { Coverage } from '../shared/protocol';
import { svg } from '../shared/svg';
import { text } from '../shared/texts';
import type { Helper } from './actions';
import { tellCoverage, type CoverageGroup, type CoverageMark, type Sentence } from './coverage';
import { drawPlan, type PlanDrawing } from './plan/plan_drawing';
import { card } from './shell';

const kAgainMs = 5_000;

export function coverageCard({ store }: Helper): HTMLElement {
  const place = h('div', { class: 'form' });
  const element = card(text('coverage.heading'), h('p', { class: 'hint' }, text('coverage.explain')), place);
  let asked = 0; // what was asked before is old

  async function show(): Promise<void> {
    asked += 1;
    const mine = asked;
    let children: Child[];
    try {
      children = view(await request<Coverage>('GET', '/api/coverage'));
    } catch (error) {
      const isSoon = error instanceof ApiError && error.status === 503;
      const words = h('p', { class: 'hint' });
      showWhy(words, isSoon ? text('coverage.not_ready') : error);
      children = [words];
      if (isSoon) {
        setTimeout(() => mine === asked && void show(), kAgainMs);
      }
    }
    if (mine === asked) {
      replaceChildren(place, ...children);
    }
  }

  function view(coverage: Coverage): Child[] {
    const { home, plan } = store.state;
    if (!home) {
      return [];
    }
    const { groups, marks } = tellCoverage(coverage, home, plan);
    return [
      marks.length > 0 ? stage(groups, marks) : null,
      groups.length === 0 ? h('p', {}, text('coverage.nothing')) : h('ul', { class: 'coverage' }, ...groups.map(groupView)),
      coverage.floor_known ? null : h('p', { class: 'hint' }, text('coverage.no_floor')),
    ];
  }

  function stage(groups: readonly CoverageGroup[], marks: readonly CoverageMark[]): HTMLElement {
    const named = groups.filter(({ mark }) => mark !== '').map(({ mark, heading }) => text('coverage.mark', { number: mark, what: heading }));
    const drawing = drawPlan(store.state.plan, null, text('coverage.plan', { marks: named.join(', ') }));
    drawing.overlay.append(...marks.map((one) => markOf(drawing, one)));
    return h('div', { class: 'plan-stage looked-at' }, drawing.element);
  }

  // Of nothing that is not there yet, nothing is missing.
  store.watch(['home', 'job'], () => {
    const { home, job } = store.state;
    element.hidden = !home || home.recordings.length === 0;
    if (!element.hidden && job?.state !== 'running') {
      if (asked === 0) {
        replaceChildren(place, h('p', { class: 'hint' }, text('coverage.looking')));
      }
      void show();
    } else if (asked === 0) {
      replaceChildren(place, h('p', { class: 'hint' }, text('coverage.not_ready')));
    }
  });
  return element;
}

function groupView({ heading, mark, sentences }: CoverageGroup): HTMLElement {
  return h('li', {},
    h('h4', {}, mark === '' ? heading : text('coverage.mark', { number: mark, what: heading })),
    h('ul', { class: 'plain' }, ...sentences.map(sentenceView)));
}

function sentenceView({ mark, say, todo }: Sentence): HTMLElement {
  return h('li', {}, mark === '' ? say : text('coverage.mark', { number: mark, what: say }), ' ', h('span', { class: 'hint' }, todo));
}

const [kRadius_px, kLetter_px] = [12, 14];

function markOf({ pixel_m, upright }: PlanDrawing, { mark, at: [x, y], isRoom }: CoverageMark): SVGElement {
  const radius = kRadius_px * pixel_m;
  return svg('g', { class: 'gap', transform: `translate(${x} ${-y}) ${upright} translate(0 ${isRoom ? 2 * radius : 0})` },
    svg('circle', { r: radius }), svg('text', { 'font-size': kLetter_px * pixel_m }, mark));
}
