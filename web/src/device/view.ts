// What is on the phone's page: the state above, what was said in the middle, the questions within a thumb's reach.
import { h, replaceChildren } from '../shared/dom';
import { icon } from '../shared/icons';
import type { GuideWish } from '../shared/protocol';
import { text } from '../shared/texts';
import { Cover } from './cover';
import type { PhoneState } from './phone';
import type { SaidLog } from './said_log';

export interface ViewActions {
  whereAmI: () => void;
  aroundMe: () => void;
  find: () => void;
  take: () => void;
  spots: () => void;
  askInWords: () => void;
  guide: (wish: GuideWish) => void;
  hideWalks: () => void;
  repeat: () => void;
  quiet: () => void;
  nameRoom: () => void;
  record: () => void;
  stopRecording: () => void;
  howFar: () => void;
  teach: () => void;
  stopTeaching: () => void;
  settings: () => void;
}

export class PhoneView {
  readonly element: HTMLElement;
  private readonly heading = h('h1', {}, 'Roomwise');
  private readonly connection = h('li', { class: 'chip' });
  private readonly camera = h('li', { class: 'chip' });
  private readonly quiet: HTMLButtonElement;
  private readonly nameRoom: HTMLButtonElement;
  private readonly guide: HTMLElement;
  private readonly hide: HTMLButtonElement; // the walk from helpers
  private readonly lock: HTMLButtonElement; // against touches that nobody means
  private readonly cover = new Cover(() => (this.guide.hidden ? this.element.querySelector<HTMLElement>('.tool.take') : this.lock)?.focus());
  private readonly record: HTMLButtonElement;
  private readonly teach: HTMLButtonElement;
  private readonly stopTeaching: HTMLButtonElement; // of what was shown and has no name yet
  private readonly stop: HTMLButtonElement; // of a recording that goes on without its pictures
  private readonly questions: HTMLElement;
  private readonly walk: HTMLElement; // what is asked and done while one walks

  constructor(video: HTMLVideoElement, log: SaidLog, speak: HTMLElement, actions: ViewActions, private readonly isHelper: () => boolean) {
    const question = (name: string, label: string, shape: Parameters<typeof icon>[0], run: () => void) =>
      h('button', { type: 'button', class: `question ${name}`, onclick: run }, icon(shape), h('span', {}, label));
    this.nameRoom = h('button', { type: 'button', class: 'tool', hidden: true, onclick: actions.nameRoom }, text('phone.name_room'));
    this.lock = h('button', { type: 'button', class: 'tool', onclick: () => this.cover.close() }, text('guide.lock'));
    this.hide = h('button', { type: 'button', class: 'tool hide', hidden: true, onclick: actions.hideWalks }, text('guide.hide'));
    const wish = (name: GuideWish) =>
      h('button', { type: 'button', class: 'tool', onclick: () => actions.guide(name) }, text(`guide.${name}`));
    this.guide = h('section', { class: 'guide', hidden: true, 'aria-labelledby': 'guide-heading' },
      h('h2', { id: 'guide-heading', class: 'visually-hidden' }, text('guide.label')),
      wish('next'), wish('how_far'), wish('blocked'), wish('pause'), wish('resume'), wish('end'), this.lock, this.hide);
    this.record = h('button', { type: 'button', class: 'tool', onclick: actions.record }, text('phone.record'));
    this.teach = h('button', { type: 'button', class: 'tool teach', onclick: actions.teach }, text('teach.begin'));
    this.stopTeaching = h('button', { type: 'button', class: 'tool', hidden: true, onclick: actions.stopTeaching }, text('teach.stop'));
    this.stop = h('button', { type: 'button', class: 'tool', hidden: true, onclick: actions.stopRecording }, text('record.stop'));
    this.quiet = question('quiet', text('phone.quiet'), 'quiet', actions.quiet);
    this.quiet.setAttribute('aria-pressed', 'false');
    this.questions = h('section', { class: 'questions', 'aria-labelledby': 'ask-heading' },
      h('h2', { id: 'ask-heading', class: 'visually-hidden' }, text('phone.ask')),
      question('find', text('phone.find'), 'find', actions.find),
      question('around', text('phone.around_me'), 'around', actions.aroundMe),
      question('where', text('phone.where_am_i'), 'where', actions.whereAmI),
      question('repeat', text('phone.repeat'), 'repeat', actions.repeat),
      this.quiet);
    this.walk = h('section', { class: 'questions walk', hidden: true, 'aria-labelledby': 'walk-heading' },
      h('h2', { id: 'walk-heading', class: 'visually-hidden' }, text('phone.walk')),
      question('name', text('phone.name_room'), 'tick', actions.nameRoom),
      question('how-far', text('phone.how_far'), 'around', actions.howFar),
      question('where stop', text('record.stop'), 'cross', actions.stopRecording));
    this.element = h('div', { class: 'phone' },
      h('header', { class: 'bar' },
        this.heading,
        h('div', { class: 'tools' },
          this.nameRoom,
          h('button', { type: 'button', class: 'tool take', onclick: actions.take }, text('phone.take')),
          h('button', { type: 'button', class: 'tool spots', onclick: actions.spots }, text('phone.spots')),
          h('button', { type: 'button', class: 'tool', onclick: actions.askInWords }, text('phone.in_words')),
          speak,
          this.stop,
          this.record,
          this.teach,
          this.stopTeaching,
          h('button', { type: 'button', class: 'tool', onclick: actions.settings }, text('phone.settings')))),
      this.cover.top,
      h('main', {},
        h('section', { class: 'now', 'aria-label': text('phone.state') },
          h('ul', { class: 'chips' }, this.connection, this.camera), video),
        h('section', { class: 'answers', 'aria-labelledby': 'said-heading' },
          h('h2', { id: 'said-heading', class: 'visually-hidden' }, text('said.label')), log.element),
        this.guide, this.questions, this.walk),
      this.cover.bottom);
  }

  show(state: PhoneState): void {
    this.heading.textContent = state.home || 'Roomwise';
    chip(this.connection, state.online ? 'good' : 'bad',
      text(state.online ? 'phone.connected' : 'phone.not_connected'));
    if (state.online && state.recording) {
      chip(this.camera, 'good', text('phone.recording', { name: state.recording }));
    } else {
      chip(this.camera, state.camera === 'good' ? 'good' : 'bad', text(`phone.camera_${state.camera}`));
    }
    this.quiet.setAttribute('aria-pressed', String(state.quiet));
    this.teach.textContent = text(state.teaching === 'no' ? 'teach.begin' : state.teaching === 'showing' ? 'teach.stop' : 'teach.go');
    document.body.classList.toggle('walking', state.isWalking);
    // Only a walk that is being recorded by this device can be named from here.
    const shown: [HTMLElement, boolean][] = [
      [this.guide, state.led && !state.isWalking], [this.hide, state.mayWatch],
      [this.questions, !state.isWalking], [this.walk, state.isWalking], [this.record, !state.isWalking], [this.teach, !state.isWalking],
      [this.stopTeaching, state.teaching === 'shown' && !state.isWalking],
      [this.nameRoom, state.recording !== null && !state.isWalking], [this.stop, state.waits && this.isHelper()],
    ];
    const focused = document.activeElement;
    for (const [part, isShown] of shown) {
      part.hidden = !isShown;
    }
    const left = shown.find(([part, isShown]) => !isShown && part.contains(focused))?.[0];
    if (left !== undefined) {
      const next = state.isWalking ? '.question.stop' : left === this.hide ? '.guide .tool' : left === this.guide ? '.tool.take' : left === this.stopTeaching ? '.tool.teach' : '.question.where';
      this.element.querySelector<HTMLElement>(next)?.focus();
    }
  }
}

// A tick or a cross beside the words: colour is never the only sign.
function chip(element: HTMLElement, kind: 'good' | 'bad', words: string): void {
  if (element.textContent !== words || !element.classList.contains(kind)) {
    element.className = `chip ${kind}`;
    replaceChildren(element, icon(kind === 'good' ? 'tick' : 'cross'), words);
  }
}
