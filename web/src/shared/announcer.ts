// Says the result of an action once: shown at the foot of the page, and read politely by a screen reader.
import { showWhy } from './api';
import { h } from './dom';
import { icon } from './icons';
import { text } from './texts';

export class Announcer {
  private readonly said = h('div', { role: 'status', 'aria-live': 'polite' });
  private readonly close = h('button', {
    type: 'button', class: 'dismiss', hidden: true, 'aria-label': text('announcer.close'), onclick: () => this.dismiss(),
  }, icon('cross'));
  readonly element = h('div', { class: 'announcer' }, this.said, this.close);
  private before: EventTarget | null = null; // had the focus

  constructor() {
    this.close.addEventListener('focus', (event) => (this.before = event.relatedTarget));
    document.addEventListener('focusin', () => this.uncoverSoon());
  }

  clear(): void {
    this.said.textContent = '';
    this.close.hidden = true;
  }

  // Words or an error. A new element each time: so the same words twice are read twice.
  say(what: unknown, kind: 'done' | 'failed' = 'done'): void {
    this.clear();
    const shown = h('p', { class: `announcement ${kind}` });
    showWhy(shown, what);
    this.said.append(shown);
    this.close.hidden = false;
    this.uncoverSoon();
  }

  private dismiss(): void {
    const hadFocus = document.activeElement === this.close;
    this.clear();
    if (hadFocus && this.before instanceof HTMLElement) {
      this.before.focus();
    }
  }

  // What has the focus is not to lie under it: the page is scrolled, once it has its layout.
  private uncoverSoon(): void {
    window.requestAnimationFrame(() => {
      const focused = document.activeElement;
      if (focused === null || focused.contains(this.element) || this.element.contains(focused) || focused.closest('dialog')) {
        return;
      }
      const [over, under] = [this.said.getBoundingClientRect(), focused.getBoundingClientRect()];
      if (over.height > 0 && under.bottom > over.top && under.top < over.bottom && under.right > over.left && under.left < over.right) {
        focused.scrollIntoView({ block: 'center' });
      }
    });
  }
}
