// The pictures of a walk in a row. Arrow keys move, Shift with them (or Shift and a click) chooses several.
import { h } from '../shared/dom';
import type { Keyframe, RoomRange } from '../shared/protocol';
import { formatMoment, text } from '../shared/texts';
import { keyframeAddress } from './pictures';
import { roomAt, type FrameSpan } from './ranges';

const kPage = 10;
const kMargin = 8; // px, before the picture that is scrolled to

export class Timeline {
  readonly element = h('ul', {
    class: 'timeline', role: 'listbox', 'aria-multiselectable': 'true', 'aria-label': text('walks.pictures'),
    'aria-orientation': 'horizontal',
  });
  private spans: FrameSpan[] = [];
  private anchor = 0;
  private head = 0;

  // `chosen`: the first and the last chosen picture, by their place in the row.
  constructor(private readonly chosen: (first: number, last: number) => void) {
    this.element.addEventListener('keydown', (event) => this.key(event));
    this.element.addEventListener('click', (event) => this.click(event));
  }

  show(keyframes: readonly Keyframe[], spans: FrameSpan[], ranges: readonly RoomRange[]): void {
    const same = spans.length === this.spans.length && spans.every((span, i) => span.keyframe === this.spans[i]?.keyframe);
    this.spans = spans;
    if (!same) {
      this.anchor = this.head = 0;
      this.element.textContent = '';
      this.element.append(...spans.map((span) => option(span, keyframes.find(({ id }) => id === span.keyframe))));
    }
    const rooms = [...new Set(ranges.map((range) => range.room))].sort();
    this.options().forEach((one, i) => label(one, i, this.spans[i] as FrameSpan, ranges, rooms));
    this.mark();
  }

  // Marks these pictures, as they were typed elsewhere.
  select(first: number, last: number): void {
    if (first >= 0 && last < this.spans.length && first <= last) {
      this.anchor = first;
      this.head = last;
      this.mark();
      // Not scrollIntoView: the page stays where somebody types.
      const from = this.options()[this.anchor] as HTMLElement;
      this.element.scrollLeft = from.offsetLeft - this.element.offsetLeft - kMargin;
    }
  }

  private key(event: KeyboardEvent): void {
    const steps: Record<string, number> = {
      ArrowRight: 1, ArrowDown: 1, ArrowLeft: -1, ArrowUp: -1, PageDown: kPage, PageUp: -kPage,
      Home: -this.spans.length, End: this.spans.length,
    };
    const step = steps[event.key] ?? (event.key === ' ' ? 0 : null);
    if (step === null) {
      return;
    }
    event.preventDefault();
    this.moveTo(this.head + step, event.shiftKey);
  }

  private click(event: MouseEvent): void {
    const at = this.options().findIndex((one) => one.contains(event.target as Node));
    if (at >= 0) {
      this.moveTo(at, event.shiftKey);
    }
  }

  private moveTo(place: number, extend: boolean): void {
    this.head = Math.max(0, Math.min(this.spans.length - 1, place));
    this.anchor = extend ? this.anchor : this.head;
    this.mark();
    this.options()[this.head]?.focus();
    const [from, to] = [Math.min(this.anchor, this.head), Math.max(this.anchor, this.head)];
    this.chosen(from, to);
  }

  private mark(): void {
    const [from, to] = [Math.min(this.anchor, this.head), Math.max(this.anchor, this.head)];
    this.options().forEach((one, i) => {
      one.setAttribute('aria-selected', String(i >= from && i <= to));
      one.tabIndex = i === this.head ? 0 : -1;
    });
  }

  private options(): HTMLElement[] {
    return [...this.element.children] as HTMLElement[];
  }
}

function option(span: FrameSpan, keyframe: Keyframe | undefined): HTMLElement {
  return h('li', { role: 'option' },
    keyframe ? h('img', { src: keyframeAddress(span.keyframe), alt: '', loading: 'lazy', decoding: 'async' }) : null,
    h('span', { class: 'number' }), ' ', h('span', { class: 'room-name' }));
}

// Words and a stripe of one of six patterns; the words are what counts.
function label(one: HTMLElement, place: number, span: FrameSpan, ranges: readonly RoomRange[], rooms: readonly string[]): void {
  const room = roomAt(ranges, span.first);
  const [number, name] = [...one.querySelectorAll('span')] as HTMLElement[];
  (number as HTMLElement).textContent = text('walks.picture', { number: place + 1, time: formatMoment(span.time_s) });
  (name as HTMLElement).textContent = room ?? text('walks.unnamed');
  one.className = room === null ? 'unnamed' : `stripe-${rooms.indexOf(room) % 6}`;
}
