// The phone: joins camera, connection and speech. What a person sees and touches is in view.ts.
import { browserSession } from '../shared/browser_session';
import { frameEnvelope } from '../shared/frame_envelope';
import {
  kProtocolVersion, type FromComputer, type Hello, type Question, type RecordingState, type Welcome,
} from '../shared/protocol';
import type { Session } from '../shared/session';
import type { SpokenKey } from '../shared/spoken';
import { language } from '../shared/texts';
import type { Camera } from './camera';
import { CameraWatch, type CameraNews } from './camera_watch';
import { ConnectionWatch, kLookEveryMs, type ConnectionNews } from './connection_watch';
import { FrameSender, kFrameGapMs } from './frame_sender';
import { answerPrompt, ownPrompt } from './own_prompt';
import { measureQuality, troubleOf } from './picture_quality';
import type { PromptPlayer } from './prompt_player';
import type { Settings } from './settings';

export interface PhoneState {
  home: string;
  rooms: string[];
  things: string[];
  online: boolean;
  camera: 'off' | 'good' | 'dark' | 'covered' | 'blurred';
  recording: string | null;
  quiet: boolean;
}

export class Phone {
  readonly state: PhoneState = {
    home: '', rooms: [], things: [], online: false, camera: 'off', recording: null, quiet: false,
  };
  private readonly session: Session;
  private readonly sender = new FrameSender();
  private readonly connection = new ConnectionWatch(performance.now());
  private cameraWatch = new CameraWatch();
  private helloCamera: string = '';
  private grabbing = false;
  private everOnline = false;

  constructor(
    private readonly name: string,
    private readonly camera: Camera,
    private readonly player: PromptPlayer,
    private readonly settings: Settings,
    private readonly changed: () => void,
    private readonly refused: () => void, // the socket was closed before it opened: perhaps no longer paired
  ) {
    this.session = browserSession({
      hello: () => this.hello(),
      onMessage: (message) => this.receive(message),
      onOnline: () => this.online(),
      onOffline: () => this.offline(),
    });
  }

  begin(): void {
    this.session.connect();
    window.setInterval(() => this.look(), kLookEveryMs);
  }

  ask(question: Question): void {
    this.player.hush();
    const now = performance.now();
    if (this.session.ask(question, now) === null) {
      this.player.push(ownPrompt('device.connection_lost', now, 'answer'));
    }
  }

  setQuiet(on: boolean): void {
    this.state.quiet = on;
    this.player.setQuiet(on);
    this.session.send({ type: 'quiet', on });
    this.player.push(ownPrompt(on ? 'device.quiet_on' : 'device.quiet_off', performance.now(), 'answer'));
    this.changed();
  }

  settingsChanged(): void {
    const { distances, step_m, callouts } = this.settings;
    this.session.send({ type: 'settings', language: language(), distances, step_m, callouts });
  }

  say(key: SpokenKey): void {
    this.player.push(ownPrompt(key, performance.now()));
  }

  private hello(): Hello {
    const { distances, step_m, callouts } = this.settings;
    const camera = this.camera.description;
    this.helloCamera = JSON.stringify(camera);
    return {
      type: 'hello', version: kProtocolVersion, name: this.name, kind: 'phone', camera,
      language: language(), distances, step_m, callouts,
    };
  }

  private receive(message: FromComputer): void {
    switch (message.type) {
      case 'welcome':
      case 'home':
        this.learnHome(message);
        break;
      case 'prompt':
        this.player.push(message);
        break;
      case 'frame':
        this.sender.acknowledged(message.t);
        break;
      case 'recording':
        this.tellRecording(message);
        break;
      case 'error':
        if (message.answer_to !== null && message.answer_to !== undefined) {
          this.player.push(answerPrompt(message.text, performance.now()));
        }
        break;
      default: // `seen` is for showing; the rest is for helpers
        return;
    }
    this.changed();
  }

  private learnHome(message: Partial<Pick<Welcome, 'home' | 'rooms' | 'things'>>): void {
    this.state.home = message.home ?? this.state.home;
    this.state.rooms = message.rooms ?? this.state.rooms;
    this.state.things = message.things ?? this.state.things;
  }

  private online(): void {
    this.state.online = true;
    this.everOnline = true;
    this.sender.reset();
    if (this.state.quiet) {
      this.session.send({ type: 'quiet', on: true });
    }
    this.tellConnection(this.connection.online());
    this.changed();
  }

  private offline(): void {
    const wasOnline = this.state.online;
    this.state.online = false;
    this.state.recording = null;
    this.sender.reset();
    this.connection.offline(performance.now());
    if (!wasOnline) {
      this.refused();
    }
    this.changed();
  }

  // Four times a second.
  private look(): void {
    const now = performance.now();
    if (this.sender.stalled(now)) {
      this.tellConnection(this.connection.gone());
      this.session.reconnect();
    }
    this.tellConnection(this.connection.look(now));
    if (document.visibilityState === 'visible') {
      this.lookAtPicture(now);
    }
  }

  private lookAtPicture(now: number): void {
    const grey = this.camera.grey();
    if (!grey) {
      this.setCamera('off');
      return;
    }
    const trouble = troubleOf(measureQuality(grey));
    this.tellCamera(this.cameraWatch.see(trouble, now));
    this.setCamera(this.cameraWatch.troubled ?? 'good');
    if (this.session.online && JSON.stringify(this.camera.description) !== this.helloCamera) {
      this.session.reconnect(); // the camera came later, or the phone was turned: hello is said anew
      return;
    }
    void this.sendPicture();
  }

  private async sendPicture(): Promise<void> {
    const t = performance.now();
    const gap = this.state.recording ? 0 : kFrameGapMs - 20; // the look's timer may be early
    if (this.grabbing || !this.session.online || !this.sender.mayStart(t, gap)) {
      return;
    }
    this.grabbing = true;
    try {
      const picture = await this.camera.jpeg();
      if (picture && this.session.sendFrame(frameEnvelope(t, picture))) {
        this.sender.sent(t, performance.now());
      }
    } finally {
      this.grabbing = false;
    }
  }

  private tellRecording({ state, name }: RecordingState): void {
    const before = this.state.recording;
    this.state.recording = state === 'recording' ? name : null;
    if (state !== 'recording') {
      this.say(`device.recording_${state}`);
    } else if (before === null) {
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
    if (news) {
      this.say(this.everOnline || news === 'back' ? `device.connection_${news}` : 'device.connecting');
    }
  }
}
