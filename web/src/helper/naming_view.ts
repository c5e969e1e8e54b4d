// Naming rooms on a walk: choose the first and last picture, give a name.
import { request } from '../shared/api';
import { h, newId } from '../shared/dom';
import { textField } from '../shared/forms';
import type { Keyframe, Recording, RoomRange } from '../shared/protocol';
import { formatMoment, text } from '../shared/texts';
import { actAndSay, actOrSay, mapIsMade, type Helper } from './actions';
import { required } from '../shared/form_dialog';
import { keyframeAddress } from './pictures';
import { picturesOf, spansOf, withRange, without, type FrameSpan } from './ranges';
import { rerender } from './rerender';
import { Timeline } from './timeline';

export interface NamingView {
  element: HTMLElement;
  show: (recording: Recording, keyframes: Keyframe[]) => void;
}

export function namingView(helper: Helper): NamingView {
  let recording: Recording | null = null;
  let spans: FrameSpan[] = [];
  const number = { attributes: { type: 'number', inputmode: 'numeric', min: 1 } };
  const first = textField(text('walks.first'), { ...number, value: '1' });
  const last = textField(text('walks.last'), { ...number, value: '1' });
  const ends = h('ul', { class: 'ends', 'aria-label': text('walks.chosen') });
  const names = h('datalist', { id: newId('rooms') });
  const room = textField(text('walks.room'), { attributes: { list: names.id, maxlength: 60 } });
  const timeline = new Timeline((from, to) => {
    first.input.value = String(from + 1);
    last.input.value = String(to + 1);
    showEnds();
  });
  const keys = h('p', { class: 'hint' });
  const list = h('ul', { class: 'ranges' });
  const form = h('form', { novalidate: true, class: 'form columns' },
    first.element, last.element, ends, room.element, names,
    h('button', { type: 'submit', class: 'primary' }, text('walks.save')));
  for (const field of [first, last]) {
    field.input.addEventListener('change', () => {
      timeline.select(Number(first.value()) - 1, Number(last.value()) - 1);
      showEnds();
    });
  }

  function showEnds(): void {
    const places = [...new Set([first, last].map((field) => Number(field.value()) - 1))];
    ends.replaceChildren(...places.flatMap((place) => (spans[place] ? [h('li', {}, thumbnail(spans[place]), nameOf(place))] : [])));
  }

  function nameOf(place: number): string {
    return text('walks.picture', { number: place + 1, time: formatMoment(spans[place]?.time_s ?? 0) });
  }
  form.addEventListener('submit', (event) => {
    event.preventDefault();
    save().catch((error: unknown) => room.fail(error));
  });

  async function save(): Promise<void> {
    [first, last, room].forEach((field) => field.clear());
    const chosen = checked();
    if (chosen && recording) {
      const [from, to] = chosen;
      const { id, ranges } = recording;
      const range = { first: spans[from - 1]?.first ?? 0, last: spans[to - 1]?.last ?? 0, room: room.value() };
      await actAndSay(helper, () => put(id, withRange(ranges, range)), text('walks.saved', { first: from, last: to, room: range.room }));
      room.input.value = '';
    }
  }

  // The numbers of the first and the last picture.
  function checked(): [number, number] | null {
    const most = spans.length;
    const [from, to] = [Number(first.value()), Number(last.value())];
    const isPicture = (value: number): boolean => Number.isInteger(value) && value >= 1 && value <= most;
    if (!isPicture(from)) {
      first.fail(text('walks.no_picture', { most }));
      return null;
    }
    if (!isPicture(to) || to < from) {
      last.fail(text(isPicture(to) ? 'walks.wrong_order' : 'walks.no_picture', { most }));
      return null;
    }
    return required(room, text('room.name_missing')) ? [from, to] : null;
  }

  async function put(id: number, ranges: RoomRange[]): Promise<void> {
    await request('PUT', `/api/recordings/${id}/rooms`, { ranges });
    await helper.store.refreshHome();
  }

  function rangeLine(id: number, ranges: readonly RoomRange[], range: RoomRange): HTMLElement {
    const pictures = picturesOf(spans, range);
    const at = (place: number): string => formatMoment(spans[place]?.time_s ?? 0);
    const numbers = pictures && { first: pictures[0] + 1, last: pictures[1] + 1 };
    const words = pictures && numbers
      ? text('walks.range', { ...numbers, from: at(pictures[0]), to: at(pictures[1]), room: range.room })
      : text(mapIsMade(helper) ? 'walks.range_waits' : 'walks.range_hidden', { room: range.room });
    if (!pictures && mapIsMade(helper)) {
      return h('li', {}, words);
    }
    const removed = numbers ? text('walks.range_removed', numbers) : text('walks.hidden_removed');
    const remove = (): void => actOrSay(helper, () => put(id, without(ranges, range.first, range.last)), removed);
    const seen = pictures ? spans[pictures[0]] : undefined;
    return h('li', {}, h('span', { class: 'pictured' }, seen ? thumbnail(seen) : null, words),
      h('button', { type: 'button', class: 'small', 'data-key': `range ${range.first}`, 'aria-label': `${text('walks.remove')} ${words}`, onclick: remove }, text('walks.remove')));
  }

  return {
    element: h('div', { class: 'form' },
      timeline.element, keys, form, h('h4', {}, text('walks.named')), list),
    show: (now, keyframes) => {
      recording = now;
      spans = spansOf(keyframes, now.frames);
      timeline.element.hidden = form.hidden = keyframes.length === 0;
      keys.textContent = text(keyframes.length === 0 ? 'walks.no_pictures' : 'walks.keys');
      timeline.show(keyframes, spans, now.ranges);
      showEnds();
      names.replaceChildren(...(helper.store.state.home?.rooms ?? []).map((one) => h('option', { value: one.name })));
      rerender(list, now.ranges.length === 0
        ? [h('li', {}, text('walks.nothing_named'))]
        : now.ranges.map((range) => rangeLine(now.id, now.ranges, range)));
    },
  };
}

function thumbnail(span: FrameSpan): HTMLElement {
  return h('img', { class: 'thumbnail', src: keyframeAddress(span.keyframe), alt: '', loading: 'lazy', decoding: 'async' });
}
