// Learning the rooms, trying a picture, and what was recognised of late.
import { request } from '../shared/api';
import { at } from '../shared/base';
import { h, replaceChildren } from '../shared/dom';
import { textField } from '../shared/forms';
import type { Recognition, TestResult, Verdict } from '../shared/protocol';
import { formatNumber, formatPercent, formatTime, text } from '../shared/texts';
import { actOrSay, type Helper } from './actions';
import { jobView } from './job_view';
import { photosCard } from './photos_card';
import { rerender } from './rerender';
import { card, panel } from './shell';
import { trialCard } from './trial_card';

export function recognisePanel(helper: Helper): HTMLElement {
  return panel(text('nav.recognise'), photosCard(helper), learnCard(helper), trialCard(helper), testCard(helper), recognitionsCard(helper));
}

function learnCard(helper: Helper): HTMLElement {
  const state = h('p', {});
  helper.store.watch(['home'], () => {
    const learned = helper.store.state.home?.learned;
    state.textContent = learned
      ? text('learn.learned', { pictures: formatNumber(learned.pictures) })
      : text('learn.not_yet');
  });
  const start = (): void => actOrSay(helper, () => request('POST', '/api/learn'), text('learn.started'));
  return card(text('learn.heading'), state,
    h('div', { class: 'row' }, h('button', { type: 'button', class: 'primary', onclick: start }, text('learn.start'))),
    jobView(helper, 'learn'));
}

function testCard(helper: Helper): HTMLElement {
  const file = textField(text('test.picture'), {
    hint: text('test.hint'), attributes: { type: 'file', accept: 'image/jpeg,image/png,image/webp' },
  });
  const result = h('div', { class: 'result' });
  const form = h('form', { novalidate: true, class: 'form' }, file.element,
    h('div', { class: 'row' }, h('button', { type: 'submit', class: 'primary' }, text('test.go'))));
  form.addEventListener('submit', (event) => {
    event.preventDefault();
    tryPicture().catch((error: unknown) => file.fail(error));
  });

  async function tryPicture(): Promise<void> {
    file.clear();
    const picture = (file.input as HTMLInputElement).files?.[0];
    if (!picture) {
      file.fail(text('test.missing'));
      return;
    }
    const answer = await request<TestResult>('POST', '/api/test', picture);
    replaceChildren(result, resultView(picture, answer));
    helper.announcer.say(verdictWords(answer.verdict, answer.room, answer.probability));
  }
  return card(text('test.heading'), form, result);
}

function resultView(picture: File, answer: TestResult): HTMLElement {
  const image = h('img', { src: URL.createObjectURL(picture), alt: text('test.your_picture') });
  image.addEventListener('load', () => URL.revokeObjectURL(image.src));
  return h('div', { class: 'verdict' }, image,
    h('div', { class: 'form' },
      h('p', { class: 'verdict-words' }, verdictWords(answer.verdict, answer.room, answer.probability)),
      h('table', {},
        h('caption', {}, text('test.table')),
        h('thead', {}, h('tr', {}, h('th', { scope: 'col' }, text('test.room')), h('th', { scope: 'col' }, text('test.probability')))),
        h('tbody', {}, ...answer.rooms.map((one) => h('tr', {}, h('th', { scope: 'row' }, one.room), h('td', {}, formatPercent(one.probability))))))));
}

function recognitionsCard(helper: Helper): HTMLElement {
  const list = h('ul', { class: 'recognitions' });
  helper.store.watch(['recognitions'], () => {
    const { recognitions } = helper.store.state;
    rerender(list, recognitions.length === 0
      ? [h('li', {}, text('recognitions.none'))] : recognitions.map(recognitionView));
  });
  return card(text('recognitions.heading'), h('p', { class: 'hint' }, text('recognitions.explain')), list);
}

function recognitionView(one: Recognition): HTMLElement {
  return h('li', {},
    h('img', { src: at(`/api/recognitions/${one.number}/picture`), alt: '', loading: 'lazy' }),
    h('div', {},
      h('p', { class: 'verdict-words' }, verdictWords(one.verdict, one.room, one.probability)),
      h('p', { class: 'hint' }, `${one.name} · ${formatTime(one.time)}`)));
}

export function verdictWords(verdict: Verdict, room: string, probability: number): string {
  const values = { room, probability: formatPercent(probability) };
  switch (verdict) {
    case 'room':
      return text('verdict.room', values);
    case 'either':
      return text('verdict.either', values);
    case 'not sure':
      return room === '' ? text('verdict.not_sure_at_all') : text('verdict.not_sure', values);
    default: // no room is likeliest where none was learned
      return room === '' ? text('verdict.none_at_all') : text('verdict.none', values);
  }
}
