// Handing in what an app recorded: a file that is sent in pieces, then unpacked and mapped.
import { request } from '../shared/api';
import { h, setText } from '../shared/dom';
import { textField } from '../shared/forms';
import { formatNumber, formatPercent, text } from '../shared/texts';
import { handIn, UploadStopped, type UploadState } from '../shared/upload';
import { act, actOrSay, type Helper } from './actions';
import { keptRows, type Row } from './rerender';
import { card } from './shell';

export function uploadCard(helper: Helper): HTMLElement {
  const { store } = helper;
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
    sendFile().catch((error: unknown) => file.fail(error));
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
    let end = '';
    try {
      const { upload } = await handIn(chosen, browserParts, tell, stop);
      await mapIt(upload);
    } catch (error) {
      if (!(error instanceof UploadStopped)) {
        throw error;
      }
      end = text('upload.stopped');
      helper.announcer.say(end);
    } finally {
      if (stopButton.contains(document.activeElement)) {
        send.focus();
      }
      stopButton.hidden = bar.hidden = true;
      words.textContent = end;
      news.textContent = '';
      showWaiting();
    }
  }

  // Where its end is told before the answer comes, that is the newer word.
  async function mapIt(upload: string): Promise<void> {
    const before = store.state.job;
    const saySent = await act(helper, () => request('POST', `/api/uploads/${upload}/map`), text('upload.sent'));
    const { job } = store.state;
    const hasEnded = job !== before && job?.kind === 'map' && job.state !== 'running';
    if (!hasEnded) {
      saySent();
    }
    showWaiting();
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
      .then(({ uploads }) => rows(uploads))
      .catch(() => undefined); // told again by what is done next
  }

  function waitingRow({ upload, name }: UploadState): Row<UploadState> {
    const state = h('span');
    const button = (what: 'map' | 'remove', run: () => void): HTMLElement => h('button', {
      type: 'button', class: 'small', 'data-key': `${what} ${upload}`, 'aria-label': `${text(`upload.${what}`)} ${name}`, onclick: run,
    }, text(`upload.${what}`));
    const remove = button('remove', () => actOrSay(helper,
      () => request('DELETE', `/api/uploads/${upload}`).then(showWaiting), text('upload.removed', { name })));
    const map = button('map', () => void mapIt(upload).catch((error: unknown) => helper.announcer.say(error, 'failed')));
    return {
      element: h('li', {}, state, map, remove),
      show: ({ offset, bytes, is_being_mapped: isBeingMapped = false }) => {
        const isWhole = offset >= bytes;
        map.hidden = !isWhole || isBeingMapped;
        remove.hidden = isBeingMapped;
        const part = formatPercent(offset / bytes);
        setText(state, isBeingMapped ? text('upload.mapping', { name }) : isWhole ? text('upload.whole', { name }) : text('upload.part', { name, part }));
      },
    };
  }

  const rows = keptRows(waiting, ({ upload }: UploadState) => upload, waitingRow);
  let shownFor = ''; // a job's progress changes nothing here
  store.watch(['job', 'online'], () => {
    const { job, online } = store.state;
    const now = `${job?.kind} ${job?.state} ${online}`;
    if (now !== shownFor) {
      shownFor = now;
      showWaiting();
    }
  });
  return card(text('upload.heading'), h('p', { class: 'hint' }, text('upload.explain')),
    h('p', { class: 'hint' }, text('upload.when')), form, bar, words, news, waiting);
}

const browserParts = {
  begin: (file: object) => request<UploadState>('POST', '/api/uploads', file),
  put: (upload: string, offset: number, piece: Blob) => request<UploadState>('PUT', `/api/uploads/${upload}/${offset}`, piece),
  wait: (ms: number) => new Promise<void>((resolve) => window.setTimeout(resolve, ms)),
};
