// The phone's page.
import { ApiError, request } from '../shared/api';
import { at } from '../shared/base';
import { byId, h, replaceChildren } from '../shared/dom';
import type { Language, Me } from '../shared/protocol';
import { chooseLanguage, language, text } from '../shared/texts';
import { Camera, type CameraFailure } from '../shared/camera';
import { AimPlayer } from './aim';
import { openChoice } from './choice_dialog';
import { Earcons, vibrate, vibrationOf } from './earcons';
import { goalCalled } from './goals';
import { keepAwake } from './keep_awake';
import { hasLocalVoice, localVoice } from './local_voices';
import { localHearing } from './local_hearing';
import { ownNotice, ownPrompt } from './own_prompt';
import { Phone } from './phone';
import { PromptPlayer } from './prompt_player';
import type { QueuedPrompt } from './prompt_queue';
import { openSpots } from './spots_dialog';
import { SaidLog } from './said_log';
import { loadSettings, rememberPaired, saveSettings, wasPaired } from './settings';
import { openSettings } from './settings_dialog';
import { OwnVoice, ScreenReaderVoice, type Speaker } from './speaker';
import { startView } from './start_view';
import { openTeach } from './teach_dialog';
import { PhoneView } from './view';
import { openWords, SpeakButton } from './words_dialog';
import { WalkRecording } from './walk_recording';


chooseLanguage();
document.title = text('phone.title');
const page = byId('page');
const settings = loadSettings(window.localStorage);
const earcons = new Earcons();
const log = new SaidLog();
const ownVoice = new OwnVoice(log, () => settings.rate);
const readerVoice = new ScreenReaderVoice(log);
const video = h('video', { class: 'preview', playsinline: true, muted: true, 'aria-hidden': 'true', tabindex: '-1' });
video.muted = true;
const camera = new Camera(video);
const after = (ms: number, run: () => void): void => void window.setTimeout(run, ms);
const player = new PromptPlayer({
  now: () => performance.now(),
  speaker: (prompt) => speakerFor(prompt.language),
  sound,
  after,
  lostAnswer: (now) => ownPrompt('device.failed', now, 'answer'),
});
const aims = new AimPlayer({
  now: () => performance.now(),
  after,
  isSilent: () => player.isSilent,
  play: (pulse) => {
    if (settings.sounds) {
      earcons.pulse(pulse);
    }
    if (settings.vibration) {
      vibrate([pulse.buzzMs]);
    }
  },
});
let isLeaving = false;
let toldOfNoVoice = false;
localVoice(language()); // some browsers look for their voices only when they are first asked

if ('serviceWorker' in navigator) {
  // Refused where the certificate is not trusted: the page works without, only not while the computer is off.
  navigator.serviceWorker.register(at('/service_worker.js')).catch(() => undefined);
}
replaceChildren(page, startView(settings, () => void start()));

async function start(): Promise<void> {
  earcons.prime();
  if (settings.voice === 'own') {
    ownVoice.prime(language());
  }
  saveSettings(window.localStorage, settings);
  const cameraReady = camera.start();
  if (settings.voice === 'own') {
    await hasLocalVoice(language());
  }
  log.setLive(!speaksItself(language()));
  const me = await whoAmI();
  if (me !== 'not paired') {
    open(me, await cameraReady);
  }
}

// Who this device is to the computer; goes to pairing where it is nobody. Null without a connection: the page opens all
// the same and says so.
async function whoAmI(): Promise<Me | 'not paired' | null> {
  try {
    const me = await request<Me>('GET', '/api/me');
    rememberPaired(window.localStorage, true);
    return me;
  } catch (error) {
    if (error instanceof ApiError && error.status === 401) {
      goToPairing();
      return 'not paired';
    }
    return null;
  }
}

// Not without a word, where this device was paired before.
function goToPairing(): void {
  const go = (): void => location.assign(at('/pair'));
  if (isLeaving) {
    return;
  }
  isLeaving = true;
  if (!wasPaired(window.localStorage)) {
    go();
    return;
  }
  rememberPaired(window.localStorage, false);
  if (!log.element.isConnected) {
    replaceChildren(page, h('main', {}, h('h1', {}, 'Roomwise'), log.element));
  }
  player.sayLast(ownPrompt('device.removed', performance.now()), go);
}

function open(me: Me | null, cameraFailure: CameraFailure | null): void {
  const phone: Phone = new Phone(me, camera, player, settings, () => view.show(phone.state), whoAmI);
  const isHelper = (): boolean => me?.role === 'helper';
  const recording = new WalkRecording(phone, camera, player, () => (isHelper() ? 'helper' : 'device'));
  const ask = (words: string): void => phone.ask({ question: 'in_words', text: words });
  const speak = new SpeakButton({
    hold: (hazardComes) => phone.listen(hazardComes),
    release: () => player.release(),
    ask,
    failed: (why) => phone.say(why === 'refused' ? 'device.microphone_refused' : 'device.not_understood', 'answer'),
  });
  phone.whenAsked = () => speak.stop();
  phone.whenSettled = () => saveSettings(window.localStorage, settings);
  phone.whenAimed = (aim) => (aim !== null && settings.aim ? aims.hear(aim) : aims.stop());
  void localHearing(language(), navigator.languages).then((hearing) => speak.offer(hearing));
  const nameThing = (): void => openTeach((thing, isPrivate) =>
    phone.ask({ question: 'name_thing', thing, ...(isPrivate ? { private: true } : {}) }));
  phone.whenShown = nameThing;
  const view = new PhoneView(video, log, speak.element, {
    whereAmI: () => phone.ask({ question: 'where_am_i' }),
    aroundMe: () => phone.ask({ question: 'around_me' }),
    repeat: () => phone.ask({ question: 'repeat' }),
    quiet: () => phone.setQuiet(!phone.state.quiet),
    find: () => openChoice({
      title: text('find.title'), label: text('find.label'), go: text('find.go'), missing: text('find.missing'),
    }, phone.findable.map((thing) => thing.label), (label) => phone.whereIs(goalCalled(phone.findable, label))),
    take: () => openChoice({
      title: text('take.title'), label: text('take.label'), go: text('take.go'), missing: text('take.missing'),
    }, phone.goals.map((goal) => goal.label), (label) => phone.takeMeTo(goalCalled(phone.goals, label))),
    spots: () => openSpots(phone.state.spots, {
      mark: (spot) => phone.ask({ question: 'mark_spot', ...(spot === '' ? {} : { spot }) }),
      back: () => phone.takeMeBack(),
      rename: (spot, name) => phone.ask({ question: 'rename_spot', spot, name }),
      forget: (spot) => phone.ask({ question: 'forget_spot', spot }),
    }),
    askInWords: () => openWords(speak, ask),
    guide: (wish) => phone.ask({ question: 'guide', wish }),
    hideWalks: () => phone.hideWalks(),
    nameRoom: () => openChoice({
      title: text('name_room.title'), label: text('name_room.label'), go: text('name_room.go'),
      missing: text('name_room.missing'),
    }, [...phone.roomsByLabel.keys()], (label) => phone.ask({ question: 'name_room', room: phone.roomsByLabel.get(label) ?? label })),
    record: () => void recording.begin(),
    stopRecording: () => void recording.stop(),
    howFar: () => recording.tellState(),
    teach: () => (phone.state.teaching === 'shown' ? nameThing()
      : phone.ask({ question: phone.state.teaching === 'no' ? 'teach_thing' : 'stop_teaching' })),
    stopTeaching: () => phone.ask({ question: 'stop_teaching' }),
    settings: () => openSettings(settings, { changed: () => void settingsChanged(phone), leave }),
  }, isHelper);
  view.show(phone.state);
  replaceChildren(page, view.element);
  view.element.querySelector<HTMLElement>('.question.where')?.focus();
  phone.begin();
  tellOfNoVoice();
  const cameraFailed = (why: CameraFailure): void => phone.say(`device.camera_${why}`);
  if (cameraFailure) {
    cameraFailed(cameraFailure);
  }
  keepAwake(camera, cameraFailed);
}

function sound(prompt: QueuedPrompt): number {
  if (settings.vibration) {
    vibrate(vibrationOf(prompt));
  }
  return settings.sounds ? earcons.play(prompt.sound) : 0;
}

function speaksItself(spoken: Language): boolean {
  return settings.voice === 'own' && localVoice(spoken) !== null;
}

// The phone's own voice, or the list, which is live then: never both.
function speakerFor(spoken: Language): Speaker {
  const isOwn = speaksItself(spoken);
  log.setLive(!isOwn);
  return isOwn ? ownVoice : readerVoice;
}

// Once: who chose the phone's own voice would else wonder who speaks, or why nobody does.
function tellOfNoVoice(): void {
  if (settings.voice === 'own' && !speaksItself(language()) && !toldOfNoVoice) {
    toldOfNoVoice = true;
    player.push(ownNotice('voice', text('voice.none'), performance.now()));
  }
}

async function settingsChanged(phone: Phone): Promise<void> {
  saveSettings(window.localStorage, settings);
  aims.stop();
  phone.settingsChanged();
  if (settings.voice === 'own') {
    ownVoice.prime(language()); // it may not have been, and this is a tap
    await hasLocalVoice(language());
  }
  log.setLive(!speaksItself(language()));
  tellOfNoVoice();
}

async function leave(): Promise<() => void> {
  isLeaving = true;
  try {
    await request('POST', '/api/leave');
  } catch (error) {
    isLeaving = false;
    throw error;
  }
  rememberPaired(window.localStorage, false);
  return () => player.sayLast(ownNotice('left', text('settings.left'), performance.now()), () => location.assign(at('/pair')));
}
