// Recording a walk with a connected device.
import { request } from '../shared/api';
import { at } from '../shared/base';
import { h } from '../shared/dom';
import { selectField, textField } from '../shared/forms';
import type { Me } from '../shared/protocol';
import { counted, text } from '../shared/texts';
import { actAndSay, actOrSay, type Helper } from './actions';
import { required } from '../shared/form_dialog';
import { jobView } from './job_view';
import { card } from './shell';
import { fill } from './walks_panel';

export function recordCard(helper: Helper, me: Me): HTMLElement {
  const { store } = helper;
  const device = selectField(text('record.device'), []);
  const name = textField(text('record.name'), { value: text('record.default_name'), attributes: { maxlength: 60 } });
  const start = h('button', { type: 'submit', class: 'primary' }, text('record.start'));
  const stop = h('button', { type: 'button', onclick: () => stopNow() }, text('record.stop'));
  const progress = h('p', { class: 'progress-words' });
  const form = h('form', { novalidate: true, class: 'form columns' }, device.element, name.element, h('div', { class: 'row' }, start, stop));
  form.addEventListener('submit', (event) => {
    event.preventDefault();
    startNow().catch((error: unknown) => device.fail(error));
  });

  async function startNow(): Promise<void> {
    [device, name].forEach((field) => field.clear());
    if (required(device, text('record.no_device')) && required(name, text('record.name_missing'))) {
      const body = { device: Number(device.value()), name: name.value() };
      await actAndSay(helper, () => request('POST', '/api/recording', body), text('record.started', { name: name.value() }));
    }
  }

  function stopNow(): void {
    actOrSay(helper, () => request('POST', '/api/recording/stop'), text('record.stopped'));
  }

  // A further walk needs another name; one that was typed is left alone.
  let suggested = name.value();
  store.watch(['home'], () => {
    if (name.value() === suggested) {
      suggested = freeName(text('record.default_name'), store.state.home?.recordings.map((one) => one.name) ?? []);
      (name.input as HTMLInputElement).value = suggested;
    }
  });
  store.watch(['devices'], () => {
    const online = store.state.devices.filter((one) => one.online && one.device !== me.device);
    fill(device.input as HTMLSelectElement, online.map((one) => ({ value: String(one.device), label: one.name })));
  });
  let isForgotten = false; // while the connection is lost: what is recorded is told anew
  store.watch(['recording'], () => {
    const { recording } = store.state;
    progress.textContent = recording ? wordsOf(recording) : '';
    const wasFocused = document.activeElement === stop;
    stop.hidden = recording?.state !== 'recording' && recording?.state !== 'failed'; // what could not be stored ends nothing
    if (wasFocused && stop.hidden) {
      start.focus(); // not lost with the button
      isForgotten = recording === null;
    } else if (isForgotten && !stop.hidden && document.activeElement === start) {
      stop.focus();
    }
  });
  return card(text('record.heading'), h('p', { class: 'hint' }, text('record.explain')), form,
    h('p', {}, h('a', { href: at('/device') }, text('record.with_this_phone'))), progress, jobView(helper, 'map', 'prepare'));
}

// "walk", "walk 2", "walk 3", ...
function freeName(base: string, taken: readonly string[]): string {
  for (let number = 1; ; ++number) {
    const name = number === 1 ? base : `${base} ${number}`;
    if (!taken.includes(name)) {
      return name;
    }
  }
}

function wordsOf(recording: { state: 'recording' | 'saved' | 'empty' | 'failed'; name: string; frames: number; text: string }): string {
  const state = text(`record.state_${recording.state}`, { name: recording.name });
  return [state, counted('home.frames', recording.frames), recording.text].filter((part) => part !== '').join(', ');
}
