// Handing in what an app recorded: a file that is sent in pieces, then unpacked and mapped.
import { messageOf, request } from '../shared/api';
import { h, replaceChildren } from '../shared/dom';
import { textField } from '../shared/forms';
import { formatNumber, formatPercent, text } from '../shared/texts';
import { handIn, UploadStopped, type UploadState } from '../shared/upload';
import { actAndSay, actOrSay, type Helper } from './actions';
import { rerender } from './rerender';
import { card } from './shell';

export function uploadCard(helper: Helper): HTMLElement {
  const file = textField(text('upload.file'), { hint: text('upload.hint'), attributes: { type: 'file' } });
  const send = h('button', { type: 'submit', class: 'primary' }, text('upload.send'));
  const stopButton = h('button', { type: 'button', hidden: true, onclick: () => (stop.asked = true) }, text('upload.stop'));
  const bar = h('progress', { max: 1, hidden: true, 'aria-label': text('upload.progress') });
  const words = h('p', { class: 'progress-words' });
  const news = h('p', { class: 'visually-hidden', role: 'status' });
  const waiting = h('ul', { class: 'ranges' });
  let stop = { asked: false };
  let said = -1; // quarters

  const form = h('form', { novalidate: true, class: 'form' }, file.element, h('div', { class: 'row' }, send, stopButton));
  form.addEventListener('submit', (event) => {
    event.preventDefault();
    sendFile().catch((error: unknown) => file.fail(messageOf(error)));
  });

  async function sendFile(): Promise<void> {
    file.clear();
    const chosen = (file.input as HTMLInputElement).files?.[0];
    if (!chosen) {
      file.fail(text('upload.missing'));
      return;
    }
    if (!stopButton.hidden) {
      return; // under way
    }
    stop = { asked: false };
    said = -1;
    stopButton.hidden = bar.hidden = false;
    try {
      const { upload } = await handIn(chosen, browserParts, tell, stop);
      await actAndSay(helper, () => request('POST', `/api/uploads/${upload}/map`), text('upload.sent'));
      words.textContent = '';
    } catch (error) {
      if (!(error instanceof UploadStopped)) {
        throw error;
      }
      words.textContent = text('upload.stopped');
      helper.announcer.say(text('upload.stopped'));
    } finally {
      stopButton.hidden = bar.hidden = true;
      showWaiting();
    }
  }

  function tell({ offset, bytes }: UploadState, isWaiting: boolean): void {
    bar.value = offset / bytes;
    words.textContent = isWaiting ? text('upload.waits')
      : text('upload.state', { part: formatPercent(offset / bytes), size: formatNumber(bytes / 1e6, 1) });
    const quarter = isWaiting ? -2 : Math.floor((4 * offset) / bytes);
    if (quarter !== said) {
      said = quarter;
      news.textContent = words.textContent;
    }
  }

  // What lies at the computer and is not mapped: begun elsewhere, or refused.
  function showWaiting(): void {
    request<{ uploads: UploadState[] }>('GET', '/api/uploads')
      .then(({ uploads }) => rerender(waiting, uploads.map(waitingView)))
      .catch(() => undefined); // told again by what is done next
  }

  function waitingView(one: UploadState): HTMLElement {
    const isWhole = one.offset >= one.bytes;
    const state = isWhole ? text('upload.whole', { name: one.name })
      : text('upload.part', { name: one.name, part: formatPercent(one.offset / one.bytes) });
    const remove = (): void => actOrSay(helper, () => request('DELETE', `/api/uploads/${one.upload}`).then(showWaiting), text('upload.removed', { name: one.name }));
    const map = (): void => actOrSay(helper, () => request('POST', `/api/uploads/${one.upload}/map`).then(showWaiting), text('upload.sent'));
    return h('li', {}, h('span', {}, state),
      isWhole ? h('button', { type: 'button', class: 'small', 'data-key': `map ${one.upload}`, 'aria-label': `${text('upload.map')} ${one.name}`, onclick: map }, text('upload.map')) : null,
      h('button', { type: 'button', class: 'small', 'data-key': `remove ${one.upload}`, 'aria-label': `${text('upload.remove')} ${one.name}`, onclick: remove }, text('upload.remove')));
  }

  helper.store.watch(['job', 'online'], showWaiting);
  replaceChildren(waiting);
  return card(text('upload.heading'), h('p', { class: 'hint' }, text('upload.explain')),
    h('p', { class: 'hint' }, text('upload.when')), form, bar, words, news, waiting);
}

const browserParts = {
  begin: (file: object) => request<UploadState>('POST', '/api/uploads', file),
  put: (upload: string, offset: number, piece: Blob) => request<UploadState>('PUT', `/api/uploads/${upload}/${offset}`, piece),
  wait: (ms: number) => new Promise<void>((resolve) => window.setTimeout(resolve, ms)),
};
