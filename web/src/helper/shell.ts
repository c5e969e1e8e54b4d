// The frame of the helper's page: the home's name, the ways to its parts, the part that is shown.
import { h, replaceChildren } from '../shared/dom';
import { icon } from '../shared/icons';
import { languageChoice } from '../shared/language_choice';
import { text } from '../shared/texts';
import type { Helper } from './actions';

export interface Part {
  name: string; // in the address, behind #
  title: string;
  make: () => HTMLElement; // once, when it is first shown
}

export function makeShell(helper: Helper, parts: readonly Part[]): HTMLElement {
  const heading = h('h1', {}, 'Roomwise');
  const state = h('p', { class: 'chip' });
  helper.store.watch(['home'], () => (heading.textContent = helper.store.state.home?.name ?? 'Roomwise'));
  helper.store.watch(['online'], () => {
    const { online } = helper.store.state;
    state.className = `chip ${online ? 'good' : 'bad'}`;
    replaceChildren(state, icon(online ? 'tick' : 'cross'), text(online ? 'phone.connected' : 'phone.not_connected'));
  });

  const main = h('main', { id: 'main' });
  const made = new Map<string, HTMLElement>();
  const links = parts.map((part) => h('a', { href: `#${part.name}` }, part.title));
  const show = (focus: boolean): void => {
    const name = location.hash.slice(1);
    const part = parts.find((one) => one.name === name) ?? (parts[0] as Part);
    const element = made.get(part.name) ?? part.make();
    made.set(part.name, element);
    replaceChildren(main, element);
    links.forEach((link) => {
      link.toggleAttribute('aria-current', false);
      if (link.hash === `#${part.name}`) {
        link.setAttribute('aria-current', 'page');
      }
    });
    document.title = `${part.title} – ${helper.store.state.home?.name ?? 'Roomwise'}`;
    if (focus) {
      element.querySelector<HTMLElement>('h2')?.focus();
      window.scrollTo(0, 0);
    }
  };
  window.addEventListener('hashchange', () => {
    helper.announcer.clear();
    show(true);
  });
  show(false);
  return h('div', { class: 'helper' },
    h('a', { class: 'skip', href: '#main', onclick: skipTo(main) }, text('nav.skip')),
    h('header', { class: 'bar' },
      h('div', { class: 'title' }, heading, state),
      h('nav', { 'aria-label': text('nav.label') }, h('ul', {}, ...links.map((link) => h('li', {}, link)))),
      languageChoice(),
      h('a', { href: '/help/index.html' }, text('nav.help'))),
    main,
    helper.announcer.element);
}

// The address stays what it is: it says which part is shown.
function skipTo(main: HTMLElement): (event: Event) => void {
  return (event) => {
    event.preventDefault();
    main.querySelector<HTMLElement>('h2')?.focus();
  };
}

export function panel(title: string, ...children: (Node | string | null)[]): HTMLElement {
  return h('div', { class: 'panel' }, h('h2', { tabindex: '-1' }, title), ...children);
}

// A part of a panel under its own heading.
export function card(title: string, ...children: (Node | string | null)[]): HTMLElement {
  return h('section', { class: 'card' }, h('h3', {}, title), ...children);
}
