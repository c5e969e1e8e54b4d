// What was said, newest last, to read again. A live region where the screen reader is to speak, else not.
import { sayInDialog } from '../shared/dialog';
import { h } from '../shared/dom';
import { text } from '../shared/texts';
import type { QueuedPrompt } from './prompt_queue';

const kKept = 12;

export class SaidLog {
  // Two regions, so that nothing that was written silently is read when the way of speaking changes.
  private readonly list = h('div', { class: 'said-list', role: 'log', 'aria-live': 'off', 'aria-label': text('said.label'), tabindex: '0' });
  private readonly urgent = h('div', { class: 'urgent', role: 'alert' });
  // In a dialog by itself: an alert that stood here while one was open would be read once more when that closes.
  readonly element = h('div', { class: 'said', 'data-says-in-dialog': '' }, this.urgent, this.list);
  private readonly lines = new WeakMap<QueuedPrompt, HTMLElement>();

  // 'aloud': by the screen reader, each line once, hazards at once.
  setLive(live: boolean): void {
    this.list.setAttribute('aria-live', live ? 'polite' : 'off');
  }

  // A prompt that was broken off and is said again has one line, the newest.
  add(prompt: QueuedPrompt, how: 'aloud' | 'silent'): void {
    this.list.querySelector('.newest')?.classList.remove('newest');
    this.lines.get(prompt)?.remove();
    this.urgent.textContent = '';
    const line = h('p', { class: `line newest ${prompt.priority}`, lang: prompt.language }, prompt.text);
    this.lines.set(prompt, line);
    const isUrgent = how === 'aloud' && prompt.priority === 'hazard';
    const isSaid = how === 'aloud' && sayInDialog(h('span', { lang: prompt.language }, prompt.text), isUrgent);
    if (isUrgent && !isSaid) {
      this.urgent.append(line);
      return;
    }
    this.list.append(line);
    while (this.list.childElementCount > kKept) {
      this.list.firstElementChild?.remove();
    }
    this.list.scrollTop = this.list.scrollHeight;
  }
}
