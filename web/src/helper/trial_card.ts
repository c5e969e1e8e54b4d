// Asking a question as the person would: from a place on the plan, in one's own words. What they would hear stands there
// as text, the way as a line on the plan and in words.
import { request } from '../shared/api';
import { h, replaceChildren } from '../shared/dom';
import { textField } from '../shared/forms';
import type { Point, Trial } from '../shared/protocol';
import { svg } from '../shared/svg';
import { language, text } from '../shared/texts';
import type { Helper } from './actions';
import { required } from '../shared/form_dialog';
import { drawPlan } from './plan/plan_drawing';
import { pointPicker, type PointPicker } from './plan/point_picker';
import { card } from './shell';
import { headingOf, wayWords } from './trial';

export function trialCard(helper: Helper): HTMLElement {
  const { store } = helper;
  const question = textField(text('trial.question'), { hint: text('trial.hint'), attributes: { maxlength: 200 } });
  const where = h('div', { class: 'form' });
  const result = h('div', { class: 'form' });
  const form = h('form', { novalidate: true, class: 'form' }, question.element, where,
    h('div', { class: 'row' }, h('button', { type: 'submit', class: 'primary' }, text('trial.go'))));
  let picker: PointPicker | null = null;
  let shownPlan = '';

  function newPicker(): void {
    const { home, plan } = store.state;
    if (!home || plan.rooms.length === 0) {
      picker = null;
      replaceChildren(where, h('p', { class: 'hint' }, text('trial.no_plan')));
      return;
    }
    picker = pointPicker(plan, home, { label: text('trial.place'), most: 2 });
    replaceChildren(where, picker.element,
      h('div', { class: 'row' }, h('button', { type: 'button', class: 'small', onclick: newPicker }, text('trial.anew'))));
  }

  form.addEventListener('submit', (event) => {
    event.preventDefault();
    ask().catch((error: unknown) => question.fail(error));
  });

  async function ask(): Promise<void> {
    question.clear();
    if (!required(question, text('trial.missing'))) {
      return;
    }
    const points = picker?.points() ?? [];
    const place = points[0] ? { place: points[0], heading_degrees: headingOf(points, store.state.plan) } : {};
    const answer = await request<Trial>('POST', '/api/ask', { text: question.value(), language: language(), ...place });
    replaceChildren(result,
      h('h4', {}, text('trial.said')),
      h('ul', { class: 'plain heard' }, ...answer.said.map((words) => h('li', {}, words))),
      ...alongView(answer),
      ...wayView(answer, points[0] ?? null));
    helper.announcer.say(answer.said.join(' '));
  }

  function alongView({ along }: Trial): HTMLElement[] {
    return along.length === 0 ? [] : [
      h('h4', {}, text('trial.along')), h('ol', { class: 'along' }, ...along.map((words) => h('li', {}, words)))];
  }

  function wayView({ way, goal }: Trial, from: Point | null): HTMLElement[] {
    if (from === null && picker) {
      return [h('p', { class: 'hint' }, text('trial.no_way'))];
    }
    const { home, plan } = store.state;
    if (way.length < 2) {
      return [];
    }
    const words = wayWords(way, plan);
    const drawing = drawPlan(plan, home, words);
    const [x, y] = way[0] as Point;
    drawing.overlay.append(
      svg('polyline', { class: 'way', points: way.map(([px, py]) => `${px},${-py}`).join(' ') }),
      svg('circle', { cx: x, cy: -y, r: 7 * drawing.pixel_m }));
    if (goal) {
      const d = 9 * drawing.pixel_m;
      drawing.overlay.append(svg('path', { class: 'goal', transform: `translate(${goal[0]} ${-goal[1]}) ${drawing.upright}`, d: `M0 ${-d}L${d} ${d}H${-d}Z` }));
    }
    return [h('div', { class: 'plan-stage looked-at' }, drawing.element), h('p', {}, words)];
  }

  store.watch(['home'], () => {
    const plan = JSON.stringify(store.state.plan);
    if (plan !== shownPlan) { // what is set stays as long as the plan does
      shownPlan = plan;
      newPicker();
    }
  });
  return card(text('trial.heading'), h('p', { class: 'hint' }, text('trial.explain')), form, result);
}
