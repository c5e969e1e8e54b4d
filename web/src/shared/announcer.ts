// Says the result of an action once: shown at the foot of the page, and read politely by a screen reader.
import { sayInDialog } from './dialog';
import { h } from './dom';

export class Announcer {
  readonly element = h('div', { class: 'announcer', role: 'status', 'aria-live': 'polite' });

  clear(): void {
    this.element.textContent = '';
  }

  // A new element each time: so the same words twice are read twice.
  say(words: string, kind: 'done' | 'failed' = 'done'): void {
    this.element.textContent = '';
    this.element.append(h('p', { class: `announcement ${kind}` }, words));
    sayInDialog(h('p', {}, words), false);
  }
}
