// Naming rooms on a walk: choose the first and last picture, give a name.
import { messageOf, request } from '../shared/api';
import { h, newId } from '../shared/dom';
import { textField } from '../shared/forms';
import type { Keyframe, Recording, RoomRange } from '../shared/protocol';
import { text } from '../shared/texts';
import { act, actOrSay, type Helper } from './actions';
import { required } from './form_dialog';
import { spansOf, withRange, without } from './ranges';
import { rerender } from './rerender';
import { Timeline } from './timeline';

export interface NamingView {
  element: HTMLElement;
  show: (recording: Recording, keyframes: Keyframe[]) => void;
}

export function namingView(helper: Helper): NamingView {
  let recording: Recording | null = null;
  const number = { attributes: { type: 'number', inputmode: 'numeric', min: 0 } };
  const first = textField(text('walks.first'), { ...number, value: '0' });
  const last = textField(text('walks.last'), { ...number, value: '0' });
  const names = h('datalist', { id: newId('rooms') });
  const room = textField(text('walks.room'), { attributes: { list: names.id, maxlength: 60 } });
  const timeline = new Timeline((from, to) => {
    first.input.value = String(from);
    last.input.value = String(to);
  });
  const list = h('ul', { class: 'ranges' });
  const form = h('form', { novalidate: true, class: 'form columns' },
    first.element, last.element, room.element, names,
    h('button', { type: 'submit', class: 'primary' }, text('walks.save')));
  for (const field of [first, last]) {
    field.input.addEventListener('change', () => timeline.select(Number(first.value()), Number(last.value())));
  }
  form.addEventListener('submit', (event) => {
    event.preventDefault();
    save().catch((error: unknown) => room.fail(messageOf(error)));
  });

  async function save(): Promise<void> {
    [first, last, room].forEach((field) => field.clear());
    const range = checked();
    if (range && recording) {
      const { id, ranges } = recording;
      await act(helper, () => put(id, withRange(ranges, range)), text('walks.saved', { ...range }));
      room.input.value = '';
    }
  }

  function checked(): RoomRange | null {
    const most = (recording?.frames ?? 1) - 1;
    const [from, to] = [Number(first.value()), Number(last.value())];
    const isFrame = (value: number): boolean => Number.isInteger(value) && value >= 0 && value <= most;
    if (first.value() === '' || !isFrame(from)) {
      first.fail(text('walks.no_frame', { most }));
      return null;
    }
    if (last.value() === '' || !isFrame(to) || to < from) {
      last.fail(text(to < from ? 'walks.wrong_order' : 'walks.no_frame', { most }));
      return null;
    }
    return required(room, text('room.name_missing')) ? { first: from, last: to, room: room.value() } : null;
  }

  async function put(id: number, ranges: RoomRange[]): Promise<void> {
    await request('PUT', `/api/recordings/${id}/rooms`, { ranges });
    await helper.store.refreshHome();
  }

  function rangeLine(id: number, ranges: readonly RoomRange[], range: RoomRange): HTMLElement {
    const words = text('walks.range', { ...range });
    const remove = (): void => actOrSay(helper, () => put(id, without(ranges, range.first, range.last)), text('walks.range_removed', { ...range }));
    return h('li', {}, h('span', {}, words),
      h('button', { type: 'button', class: 'small', 'data-key': `range ${range.first}`, 'aria-label': `${text('walks.remove')} ${words}`, onclick: remove }, text('walks.remove')));
  }

  return {
    element: h('div', { class: 'form' },
      timeline.element, h('p', { class: 'hint' }, text('walks.keys')), form, h('h4', {}, text('walks.named')), list),
    show: (now, keyframes) => {
      recording = now;
      timeline.show(keyframes, spansOf(keyframes, now.frames), now.ranges);
      names.replaceChildren(...(helper.store.state.home?.rooms ?? []).map((one) => h('option', { value: one.name })));
      rerender(list, now.ranges.length === 0
        ? [h('li', {}, text('walks.nothing_named'))]
        : now.ranges.map((range) => rangeLine(now.id, now.ranges, range)));
    },
  };
}
