// How far a job is: a bar and words; every quarter and every stage of it is announced.
import { request } from '../shared/api';
import { h } from '../shared/dom';
import { wordsOfEnd, wordsOfStage } from '../shared/job_words';
import type { Job, JobKind } from '../shared/protocol';
import { counted, formatPercent, text } from '../shared/texts';
import { actOrSay, type Helper } from './actions';

export function jobView(helper: Helper, ...kinds: [JobKind, ...JobKind[]]): HTMLElement {
  const { store } = helper;
  const bar = h('progress', { max: 1, 'aria-label': text(`job.${kinds[0]}`) });
  // For the eyes; the bar says the same, and what is new is said below.
  const words = h('p', { class: 'progress-words', 'aria-hidden': 'true' });
  const news = h('p', { class: 'visually-hidden', role: 'status' });
  const stop = h('button', { type: 'button', onclick: () => stopNow() }, text('job.stop'));
  const running = h('div', { class: 'job' }, bar, stop);
  const element = h('div', { class: 'form' }, running, words, news);
  let said = '';
  let seenRunning = false; // what ended well before this page was opened is no news

  function stopNow(): void {
    actOrSay(helper, () => request('POST', '/api/job/stop'), text('job.stop_asked'));
  }

  store.watch(['job'], () => {
    const { job } = store.state;
    const mine = job && kinds.includes(job.kind) ? job : null;
    running.hidden = mine?.state !== 'running';
    seenRunning ||= mine?.state === 'running';
    element.hidden = mine === null || (mine.state === 'done' && !seenRunning);
    if (!mine || element.hidden) {
      return;
    }
    bar.value = mine.fraction;
    bar.setAttribute('aria-label', text(`job.${mine.kind}`));
    words.textContent = wordsOf(mine);
    words.classList.toggle('failed', mine.state === 'failed');
    if (mine.state !== 'running') {
      helper.announcer.clear(); // that it has started is no news any more
    }
    const milestone = `${mine.kind} ${mine.state} ${mine.state === 'running' ? `${Math.floor(mine.fraction * 4)} ${wordsOfStage(mine)}` : ''}`;
    if (milestone !== said) {
      said = milestone;
      news.textContent = wordsOf(mine);
    }
  });
  return element;
}

function wordsOf(job: Job): string {
  if (job.state !== 'running') {
    return [text(`job.${job.kind}_${job.state}`), wordsOfEnd(job)].filter((part) => part !== '').join(' ');
  }
  const left = job.left_s === null ? '' : leftOf(job.left_s);
  const whole = `${text(`job.${job.kind}`)}, ${formatPercent(job.fraction)}`;
  const stage = wordsOfStage(job); // what is left is of it alone
  return [stage === '' ? whole : `${whole}. ${stage}`, left].filter((part) => part !== '').join(', ');
}

function leftOf(seconds: number): string {
  return seconds < 60 ? text('job.left_less') : counted('job.left', Math.round(seconds / 60));
}
