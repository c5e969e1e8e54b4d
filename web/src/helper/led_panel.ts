// How people are led, live: the plan from above with the way and where they are, the same in words, and what the guide
// says. The computer sends it while this part is shown, of those who let helpers watch.
import { h, replaceChildren, setText } from '../shared/dom';
import { checkField } from '../shared/forms';
import type { WatchedWalk } from '../shared/protocol';
import { svg } from '../shared/svg';
import { text } from '../shared/texts';
import type { Helper } from './actions';
import { isStale, ledWords, saidAt } from './led';
import { drawPlan } from './plan/plan_drawing';
import { card, panel } from './shell';
import type { Watched } from './store';

const kLookEvery_ms = 500; // how old the places are

export function ledPanel(helper: Helper): HTMLElement {
  const { store } = helper;
  const walks = h('div', { class: 'form' });
  const others = h('ul', { class: 'plain' });
  const views = new Map<number, WalkView>(); // by device
  let isLive = false;
  const read = checkField(text('led.read'), isLive, (on) => {
    isLive = on;
    views.forEach((view) => view.setLive(on));
  });
  const element = panel(text('nav.led'),
    card(text('led.heading'), h('p', { class: 'hint' }, text('led.explain')), read.element, walks, others));

  function show(): void {
    const watched = [...store.state.watched.values()];
    for (const one of watched) {
      if (one.walk && !views.has(one.device)) {
        const view = new WalkView(helper);
        view.setLive(isLive);
        views.set(one.device, view);
        walks.append(view.element);
      }
    }
    for (const [device, view] of views) {
      const one = store.state.watched.get(device);
      if (one?.walk) {
        view.show(one, one.walk);
      } else {
        view.element.remove();
        views.delete(device);
      }
    }
    const words = watched.filter(({ walk }) => walk === null).map(({ name, may_watch }) =>
      text(may_watch ? 'led.nobody' : 'led.not_shown', { device: name }));
    replaceIfOther(others, watched.length === 0 ? [text('led.none')] : words);
  }

  store.watch(['watched', 'home'], show);
  window.setInterval(() => {
    if (element.isConnected && views.size > 0) {
      show();
    }
  }, kLookEvery_ms);
  return element;
}

function replaceIfOther(list: HTMLElement, lines: readonly string[]): void {
  if ([...list.children].map((one) => one.textContent).join('\n') !== lines.join('\n')) {
    replaceChildren(list, ...lines.map((line) => h('li', {}, line)));
  }
}

// One person's walk. Its parts stay, so that a screen reader hears what is new alone.
class WalkView {
  private readonly name = h('h4');
  private readonly state = h('p', { class: 'verdict-words', role: 'status' });
  private readonly words = h('p');
  private readonly stage = h('div', { class: 'plan-stage looked-at' });
  private readonly said = h('div', { class: 'led-said', role: 'log', 'aria-live': 'off', 'aria-label': text('led.said'), tabindex: '0' });
  readonly element = h('section', { class: 'form led' }, this.name, this.state, this.words, this.stage,
    h('h5', {}, text('led.said')), this.said);
  private newest = -Infinity; // of what was said, by the computer's clock

  constructor(private readonly helper: Helper) {}

  setLive(on: boolean): void {
    this.said.setAttribute('aria-live', on ? 'polite' : 'off');
  }

  show(watched: Watched, walk: WatchedWalk): void {
    const now = performance.now();
    const { home, plan } = this.helper.store.state;
    const words = ledWords(watched, walk, plan, now);
    this.name.textContent = watched.name;
    setText(this.state, text(`led.state_${walk.state}`));
    this.words.textContent = words;
    if (plan.rooms.length === 0) {
      this.stage.hidden = true;
    } else {
      this.stage.hidden = false;
      const drawing = drawPlan(plan, home, words);
      drawWalk(drawing, walk, isStale(watched, now) || walk.state === 'lost');
      replaceChildren(this.stage, drawing.element);
    }
    this.hear(watched, walk, now);
  }

  // Another walk begins with other words.
  private hear(watched: Watched, { said, language }: WatchedWalk, now: number): void {
    const first = said[0]?.t ?? Infinity;
    [...this.said.children].filter((line) => Number(line.getAttribute('data-t')) < first).forEach((line) => line.remove());
    const isNew = said.filter(({ t }) => t > this.newest);
    for (const one of isNew) {
      this.newest = one.t;
      this.said.append(h('p', { 'data-t': one.t },
        h('time', { class: 'hint' }, saidAt(watched, one.t, now)), ' ', h('span', { lang: language }, one.text)));
    }
    if (isNew.length > 0) {
      this.said.scrollTop = this.said.scrollHeight;
    }
  }
}

function drawWalk({ overlay, pixel_m, upright }: ReturnType<typeof drawPlan>, { way, person }: WatchedWalk, isOld: boolean): void {
  if (way.length > 1) {
    const [x, y] = way[way.length - 1] as [number, number];
    const d = 9 * pixel_m;
    overlay.append(
      svg('polyline', { class: 'way', points: way.map(([px, py]) => `${px},${-py}`).join(' ') }),
      svg('path', { class: 'goal', transform: `translate(${x} ${-y}) ${upright}`, d: `M0 ${-d}L${d} ${d}H${-d}Z` }));
  }
  if (person) {
    const r = 12 * pixel_m;
    overlay.append(svg('g', { class: `person${isOld ? ' old' : ''}`, transform: `translate(${person.x} ${-person.y}) rotate(${-person.heading_degrees})` },
      svg('circle', { class: 'unsure', r: Math.max(2 * person.sigma_m, r) }),
      svg('path', { d: `M${r} 0L${-0.8 * r} ${0.7 * r}L${-0.4 * r} 0L${-0.8 * r} ${-0.7 * r}Z` })));
  }
}
