// The phone: joins camera, connection and speech. What a person sees and touches is in view.ts.
import { browserSession } from '../shared/browser_session';
import { frameEnvelope } from '../shared/frame_envelope';
import {
  kProtocolVersion, type Aim, type FromComputer, type Hello, type Job, type Me, type NotRecorded, type Priority, type Prompt, type Question, type RecordingState,
  type ThingInRooms, type Welcome,
} from '../shared/protocol';
import type { Session } from '../shared/session';
import { roomCalled, wayOut, type SpokenKey } from '../shared/spoken';
import { language, text } from '../shared/texts';
import { AnswerWatch } from './answer_watch';
import { CameraWatch, type CameraNews } from './camera_watch';
import { ConnectionWatch, kLookEveryMs, type ConnectionNews } from './connection_watch';
import { FrameSender, kFrameGapMs } from './frame_sender';
import { goalsOf, roomLabels, type Goal } from './goals';
import { LedAgain } from './led_again';
import { ownPrompt } from './own_prompt';
import { PictureFlow } from './picture_flow';
import { measureQuality, troubleOf } from '../shared/picture_quality';
import type { PictureSource } from '../shared/picture_source';
import type { PromptPlayer } from './prompt_player';
import type { Settings } from './settings';

// Whether somebody shows a thing to the camera, and whether enough of it was seen to name it.
export type Teaching = 'no' | 'showing' | 'shown';
const kTeachingAfter: Readonly<Record<string, Teaching>> = {
  'teach.begin': 'showing', 'teach.enough': 'shown', 'teach.learning': 'no', 'teach.stopped': 'no', 'teach.no_camera': 'no',
};

export interface PhoneState {
  home: string;
  rooms: string[];
  things: string[];
  thingsInRooms: ThingInRooms[]; // of these those that must be told apart
  spots: string[]; // that were marked
  online: boolean;
  camera: 'off' | 'good' | 'dark' | 'covered' | 'blurred';
  recording: string | null;
  pictures: number; // of the recording, that the computer has
  isWalking: boolean; // by augmented reality: for a recording
  waits: boolean; // a recording, for this phone's pictures
  quiet: boolean;
  led: boolean; // is being led somewhere
  mayWatch: boolean; // helpers, how somebody is led
  teaching: Teaching;
}

function thingOf(thing: string, room: string | undefined): { thing: string; in?: string } {
  return room === undefined ? { thing } : { thing, in: room };
}

// Of these led_again.ts takes care.
function asksTheGuide(question: Question | null): boolean {
  return question !== null && ['take_me_to', 'take_me_back', 'guide'].includes(question.question);
}

// Whether a question changes nothing, so that it may be asked again where nobody knows whether it was answered.
function onlyAsks(question: Question): boolean {
  return ['where_am_i', 'around_me', 'where_is', 'which_spots', 'repeat'].includes(question.question);
}

export class Phone {
  readonly state: PhoneState = {
    home: '', rooms: [], things: [], thingsInRooms: [], spots: [], online: false, camera: 'off', recording: null, pictures: 0, isWalking: false, waits: false, quiet: false,
    led: false, mayWatch: false, teaching: 'no',
  };
  private readonly session: Session;
  private readonly sender = new FrameSender();
  private readonly answers = new AnswerWatch();
  private readonly ledAgain = new LedAgain();
  private readonly connection = new ConnectionWatch(performance.now());
  private readonly cameraWatch = new CameraWatch();
  private readonly pictures = new PictureFlow();
  private triedAgain = false; // to start the camera that ended
  private sentPicture: number | null = null; // the newest that was sent
  private helloCamera: string = '';
  private grabbing = false;
  private everOnline = false;
  private saysHelloAnew = false; // it gives the connection up itself
  private timer = 0;
  private isOver = false;
  private lastAsked = 0;
  private lastQuestion: Question | null = null;
  private unanswered: Question | null = null; // when a connection went of whose loss nobody was told
  private device: number | null; // this one's number, once the computer told it
  private heldRecording: RecordingState | NotRecorded | null = null; // came before that
  private greeted: (() => void)[] = []; // to be told once hello was said of the camera that is used now
  // Of what is recorded and what became of it; set by who records.
  whenRecording: (state: (RecordingState | NotRecorded)['state']) => void = () => undefined;
  whenJob: (job: Job) => void = () => undefined;
  whenShown: () => void = () => undefined; // enough of a thing to name it
  whenSettled: () => void = () => undefined; // a word changed the settings
  whenAsked: () => void = () => undefined; // before any question is: who listens ends that
  whenAimed: (aim: Aim | null) => void = () => undefined; // null: what was told before holds no longer

  constructor(
    private readonly me: Me | null,
    private camera: PictureSource,
    private readonly player: PromptPlayer,
    private readonly settings: Settings,
    private readonly changed: () => void,
    private readonly whoAmI: () => Promise<Me | 'not paired' | null>, // asks the computer; null: not reached
  ) {
    this.device = me?.device ?? null;
    this.state.mayWatch = settings.mayWatch;
    this.session = browserSession({
      hello: () => this.hello(),
      onMessage: (message) => this.receive(message),
      onOnline: () => this.online(),
      onOffline: () => this.offline(),
    });
  }

  // This device's, as the computer counts them; null until it told.
  get number(): number | null {
    return this.device;
  }

  begin(): void {
    this.session.connect();
    this.timer = window.setInterval(() => this.look(), kLookEveryMs);
  }

  ask(question: Question): void {
    this.whenAsked();
    this.whenAimed(null);
    this.player.withdrawAnswers();
    const now = performance.now();
    const again = this.ledAgain.wish(question);
    this.showLed(); // who ends it without a connection is led no more
    if (again !== null && this.session.online) {
      this.ask(again); // instead of going on with what the computer has forgotten
      return;
    }
    const id = this.session.ask(question, now);
    this.unanswered = null;
    if (id === null) {
      this.say('device.connection_lost', 'answer');
    } else {
      this.lastAsked = id;
      this.lastQuestion = question;
      this.ledAgain.ask(id, question);
      this.answers.ask(id, now);
    }
  }

  private askAnew(): void {
    const question = this.unanswered;
    if (question !== null && onlyAsks(question)) {
      this.ask(question);
    } else if (question !== null) {
      this.unanswered = null;
      this.say('device.failed', 'answer');
    }
  }

  takeMeTo({ kind, name, room }: Goal): void {
    if (kind === 'way out') {
      this.ask({ question: 'take_me_to', goal: 'way_out' });
    } else {
      this.ask(kind === 'room' ? { question: 'take_me_to', room: name } : { question: 'take_me_to', ...thingOf(name, room) });
    }
    this.showLed();
  }

  whereIs({ kind, name, room }: Goal): void {
    this.ask(kind === 'way out' ? { question: 'where_is', goal: 'way_out' } : { question: 'where_is', ...thingOf(name, room) });
  }

  private showLed(): void {
    if (this.state.led !== this.ledAgain.isLed) {
      this.state.led = this.ledAgain.isLed;
      this.changed();
    }
  }

  // What one may be led to.
  get goals(): Goal[] {
    return goalsOf(this.state, wayOut(language()), (room) => roomCalled(language(), room));
  }

  get findable(): Goal[] {
    return goalsOf({ ...this.state, rooms: [] }, wayOut(language()), (room) => roomCalled(language(), room));
  }

  // By what they are called in lists: how the computer knows them.
  get roomsByLabel(): Map<string, string> {
    const labels = roomLabels(this.state.rooms, (room) => roomCalled(language(), room));
    return new Map([...labels].map(([name, label]) => [label, name]));
  }

  takeMeBack(): void {
    this.ask({ question: 'take_me_back' });
    this.showLed();
  }

  // While somebody speaks a question nobody answers an earlier one, or says anything but a hazard. False: not now.
  listen(hazardComes: () => void): boolean {
    this.player.withdrawAnswers();
    return this.player.hold(hazardComes);
  }

  setQuiet(on: boolean): void {
    this.state.quiet = on;
    this.player.setQuiet(on);
    this.session.send({ type: 'quiet', on });
    this.say(on ? 'device.quiet_on' : 'device.quiet_off', 'answer');
    this.changed();
  }

  settingsChanged(): void {
    const { distances, step_m, callouts, mayWatch } = this.settings;
    this.session.send({ type: 'settings', language: language(), distances, step_m, callouts, may_watch: mayWatch });
    this.state.mayWatch = mayWatch;
    this.changed();
  }

  say(key: SpokenKey, priority: Priority = 'notice'): void {
    this.player.push(ownPrompt(key, performance.now(), priority));
  }

  // Another source of pictures: hello is said anew of it. Resolves when the computer knows it.
  use(source: PictureSource, isWalking: boolean): Promise<void> {
    this.camera = source;
    this.state.isWalking = isWalking;
    this.changed();
    return new Promise((resolve) => this.greeted.push(resolve));
  }

  setWaits(waits: boolean): void {
    this.state.waits = waits;
    this.changed();
  }

  // A source that takes its pictures by itself has a new one.
  pictureCame(): void {
    if (document.visibilityState === 'visible') {
      this.lookAtPicture(performance.now());
    }
  }

  private hello(): Hello {
    const { distances, step_m, callouts, mayWatch } = this.settings;
    const camera = this.camera.description;
    this.helloCamera = JSON.stringify(camera);
    return {
      type: 'hello', version: kProtocolVersion, name: this.me?.name ?? text('phone.unnamed'), kind: 'phone', camera,
      language: language(), distances, step_m, callouts, may_watch: mayWatch,
    };
  }

  // Kept, whether or not the computer hears of it now.
  hideWalks(): void {
    this.letWatch(false);
    this.ask({ question: 'hide_walks' });
  }

  private letWatch(may: boolean): void {
    this.settings.mayWatch = may;
    this.state.mayWatch = may;
    this.whenSettled();
    this.changed();
  }

  private receive(message: FromComputer): void {
    this.answers.heard('answer_to' in message ? message.answer_to : null, performance.now());
    switch (message.type) {
      case 'welcome':
      case 'home':
        this.ledAgain.sees(message.sees_places === true, performance.now());
        this.learnHome(message);
        break;
      case 'seen':
        this.leadOn(this.ledAgain.seen(message.position !== null, performance.now()));
        return;
      case 'aim':
        this.whenAimed(this.state.led ? message : null);
        return;
      case 'prompt':
        this.tellPrompt(message);
        break;
      case 'frame':
        this.sender.acknowledged(message.t);
        break;
      case 'recording':
        this.hearRecording(message);
        break;
      case 'error': // its words are English and for whoever mends it
        if (message.t !== null && message.t !== undefined) {
          this.sender.acknowledged(message.t); // a frame that was refused
        }
        if (message.answer_to !== null && message.answer_to !== undefined) {
          this.ledAgain.refused(message.answer_to);
          this.state.led = this.ledAgain.isLed;
          this.say('device.failed', 'answer');
        }
        break;
      case 'job':
        this.whenJob(message);
        return;
      default: // the rest is for helpers
        return;
    }
    this.changed();
  }

  // The newest question counts: an answer to one before it would only keep the newer one waiting.
  private tellPrompt(prompt: Prompt): void {
    const isOutdated = prompt.priority === 'answer' && prompt.answer_to !== null && prompt.answer_to < this.lastAsked;
    const teaching = kTeachingAfter[prompt.message];
    if (teaching !== undefined && teaching !== this.state.teaching) {
      this.state.teaching = teaching;
      if (teaching === 'shown') {
        this.whenShown();
      }
    }
    if (!isOutdated) {
      this.player.push(this.answers.inTime(prompt, performance.now())); // into the dialog that this may have opened
    }
    if (prompt.message === 'watch.shown' || prompt.message === 'watch.hidden') {
      this.letWatch(prompt.message === 'watch.shown');
    }
    this.ledAgain.heard(prompt);
    this.state.led = this.ledAgain.isLed;
  }

  private leadOn(question: Question | null): void {
    if (question !== null) {
      this.ask(question);
    }
  }

  private learnHome(message: Partial<Pick<Welcome, 'home' | 'rooms' | 'things' | 'things_in_rooms' | 'spots'>>): void {
    this.state.home = message.home ?? this.state.home;
    this.state.rooms = message.rooms ?? this.state.rooms;
    this.state.things = message.things ?? this.state.things;
    this.state.thingsInRooms = message.things_in_rooms ?? this.state.thingsInRooms;
    this.state.spots = message.spots ?? this.state.spots;
  }

  private online(): void {
    this.state.online = true;
    this.everOnline = true;
    this.sender.reset();
    this.answers.reset();
    if (this.camera.description && this.helloCamera === JSON.stringify(this.camera.description)) {
      this.greeted.splice(0).forEach((tell) => tell());
    }
    if (this.state.quiet) {
      this.session.send({ type: 'quiet', on: true });
    }
    const news = this.connection.online();
    this.tellConnection(news);
    if (news === 'back') {
      this.unanswered = null; // who was told of the loss asks again, if they still want to know
    } else if (this.camera.description === null) {
      this.askAnew(); // else with the first picture: the computer has none yet to answer by
    }
    if (this.device === null) {
      void this.identify();
    }
    this.changed();
  }

  private offline(): void {
    const wasOnline = this.state.online;
    this.state.online = false;
    this.state.teaching = 'no'; // the computer forgets what was shown
    this.sender.reset();
    if (this.answers.waits && !asksTheGuide(this.lastQuestion)) {
      this.unanswered = this.lastQuestion;
    }
    this.answers.reset();
    this.connection.offline(performance.now());
    this.whenAimed(null);
    if (wasOnline && this.ledAgain.lost() && !this.saysHelloAnew) {
      this.tellConnection(this.connection.gone());
    }
    if (!wasOnline) {
      void this.identify(); // the socket was closed before it opened: perhaps this device was removed
    }
    this.changed();
  }

  private async identify(): Promise<void> {
    const me = this.isOver ? null : await this.whoAmI();
    if (me === 'not paired') {
      this.isOver = true;
      window.clearInterval(this.timer);
      this.session.close();
    } else if (me) {
      this.device = me.device;
      if (this.heldRecording) {
        this.hearRecording(this.heldRecording);
        this.heldRecording = null;
        this.changed();
      }
    }
  }

  // Four times a second.
  private look(): void {
    const now = performance.now();
    if (this.sender.stalled(now) || this.answers.silent(now)) {
      this.tellConnection(this.connection.gone());
      this.session.reconnect();
    }
    if (this.session.online && this.answers.takesLong(now)) {
      this.say('device.one_moment', 'answer');
    }
    this.tellConnection(this.connection.look(now));
    if (document.visibilityState === 'visible') {
      this.lookAtPicture(now);
    }
  }

  private lookAtPicture(now: number): void {
    const isFlowing = this.pictures.see(this.camera.newest, now);
    const grey = isFlowing ? this.camera.grey() : null;
    if (!grey) {
      this.missPictures(now);
      return;
    }
    this.triedAgain = false;
    const trouble = troubleOf(measureQuality(grey));
    this.tellCamera(this.cameraWatch.see(trouble, now));
    const { troubled } = this.cameraWatch;
    this.setCamera(troubled === 'failed' ? 'good' : (troubled ?? 'good'));
    if (this.session.online && JSON.stringify(this.camera.description) !== this.helloCamera) {
      this.saysHelloAnew = true; // the camera came later, or the phone was turned
      this.session.reconnect();
      this.saysHelloAnew = false;
      return;
    }
    void this.sendPicture();
  }

  // A camera that never ran was told of when it was asked for.
  private missPictures(now: number): void {
    this.setCamera('off');
    if (this.camera.running || this.camera.ended) {
      this.tellCamera(this.cameraWatch.see('failed', now));
    }
    if (this.camera.ended && !this.triedAgain) {
      this.triedAgain = true;
      void this.camera.start();
    }
  }

  private async sendPicture(): Promise<void> {
    const t = performance.now();
    const newest = this.camera.newest;
    const gap = this.state.recording ? 0 : kFrameGapMs - 20; // the look's timer may be early
    if (newest === null || newest === this.sentPicture || this.grabbing || !this.session.online || !this.sender.mayStart(t, gap)) {
      return;
    }
    this.grabbing = true;
    try {
      const picture = await this.camera.frame();
      const taken = picture?.t ?? t;
      if (picture && this.session.sendFrame(frameEnvelope(taken, picture))) {
        this.sender.sent(taken, performance.now());
        this.sentPicture = newest;
        this.askAnew();
      }
    } finally {
      this.grabbing = false;
    }
  }

  // A helper's token hears of every device's.
  private hearRecording(message: RecordingState | NotRecorded): void {
    if (this.device === null) {
      this.heldRecording = message;
    } else if (message.device === this.device) {
      this.tellRecording(message);
    }
  }

  private tellRecording({ state, name, frames }: RecordingState | NotRecorded): void {
    const before = this.state.recording;
    this.state.recording = state === 'recording' ? name : null;
    this.state.pictures = frames;
    this.whenRecording(state);
    if (state === 'saved' || state === 'empty' || state === 'failed') {
      this.say(`device.recording_${state}`);
    } else if (state === 'recording' && before === null) {
      this.say('device.recording');
    }
  }

  private setCamera(camera: PhoneState['camera']): void {
    if (camera !== this.state.camera) {
      this.state.camera = camera;
      this.changed();
    }
  }

  private tellCamera(news: CameraNews): void {
    if (news) {
      this.say(news === 'better' ? 'device.camera_back' : `device.camera_${news}`);
    }
  }

  private tellConnection(news: ConnectionNews): void {
    if (news === 'lost' && this.state.led) {
      this.player.withdrawAnswers(); // words of a computer that is gone: nobody is to walk by them
      this.say('device.connection_lost_led');
    } else if (news) {
      this.say(this.everOnline || news === 'back' ? `device.connection_${news}` : 'device.connecting');
    }
  }
}
