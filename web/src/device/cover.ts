// The phone in a pocket: the page is dark and takes no touch that nobody means. It is opened by two buttons one after the other,
// far apart, or by Escape. Both are plain buttons, so that whatever presses buttons (a screen reader's double tap, a switch)
// opens it; a touch anywhere else begins anew.
import { h } from '../shared/dom';
import { text } from '../shared/texts';

export class Cover {
  readonly top: HTMLElement;
  readonly bottom: HTMLElement;
  private readonly first: HTMLButtonElement;
  private readonly second: HTMLButtonElement;

  constructor(private readonly opened: () => void) {
    this.first = h('button', { type: 'button', class: 'big', 'aria-describedby': 'cover-hint', onclick: () => this.offer(true) }, text('cover.unlock'));
    this.second = h('button', { type: 'button', class: 'big', hidden: true, onclick: () => this.open() }, text('cover.really'));
    this.top = h('section', { class: 'cover', hidden: true, 'aria-labelledby': 'cover-heading' },
      h('h2', { id: 'cover-heading' }, text('cover.title')),
      h('p', { id: 'cover-hint' }, text('cover.hint')), this.first);
    this.bottom = h('section', { class: 'cover', hidden: true, 'aria-label': text('cover.title') }, this.second);
    document.addEventListener('keydown', (event) => {
      if (this.isClosed && event.key === 'Escape') {
        event.preventDefault();
        this.open();
      }
    });
    document.addEventListener('mousedown', (event) => this.isClosed && event.preventDefault()); // no touch takes the focus away
    document.addEventListener('pointerdown', ({ target }) => {
      if (this.isClosed && !this.second.hidden && target instanceof Node && !this.second.contains(target)) {
        this.offer(false);
      }
    }, true);
  }

  close(): void {
    this.show(true);
    this.offer(false);
  }

  private get isClosed(): boolean {
    return !this.top.hidden;
  }

  private open(): void {
    this.show(false);
    this.opened();
  }

  private show(isClosed: boolean): void {
    document.body.classList.toggle('locked', isClosed);
    this.top.hidden = this.bottom.hidden = !isClosed;
  }

  // The second button in place of the first.
  private offer(isSecond: boolean): void {
    this.first.hidden = isSecond;
    this.second.hidden = !isSecond;
    (isSecond ? this.second : this.first).focus();
  }
}
