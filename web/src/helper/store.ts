// What the helper's page knows of the home; kept fresh by the socket.
import { ApiError, request } from '../shared/api';
import type {
  Device, DeviceSeen, Edit, FromComputer, Home, Job, Keyframe, Plan, Recognition, RecordingState, WatchedDevice,
} from '../shared/protocol';

export type Watched = WatchedDevice & { received: number }; // by this page's clock

export interface HelperState {
  home: Home | null;
  keyframes: Keyframe[];
  plan: Plan;
  edits: Edit[]; // the newest first
  devices: Device[];
  recognitions: Recognition[];
  job: Job | null;
  recording: RecordingState | null;
  seen: Map<number, DeviceSeen>; // by device
  watched: Map<number, Watched>; // by device
  online: boolean;
}

export type Topic = 'home' | 'devices' | 'recognitions' | 'job' | 'recording' | 'seen' | 'watched' | 'online';

export class HelperStore {
  readonly state: HelperState = {
    home: null, keyframes: [], plan: { rooms: [], doors: [] }, edits: [], devices: [], recognitions: [], job: null, recording: null, seen: new Map(), watched: new Map(), online: false,
  };
  private listeners: { topics: readonly Topic[]; run: () => void }[] = [];
  private jobsTold = 0; // by the socket
  private homesAsked = 0;
  private homeShown = 0; // which of those that were asked for

  // `run` at once, and whenever one of the topics changed, until the function that is returned is called.
  watch(topics: readonly Topic[], run: () => void): () => void {
    const listener = { topics, run };
    this.listeners.push(listener);
    run();
    return () => (this.listeners = this.listeners.filter((one) => one !== listener));
  }

  // Answers may come in another order than they were asked for: an older one changes nothing.
  async refreshHome(): Promise<void> {
    this.homesAsked += 1;
    const mine = this.homesAsked;
    const [home, map, plan, changes] = await Promise.all([
      request<Home>('GET', '/api/home'),
      request<{ keyframes: Keyframe[] }>('GET', '/api/map/keyframes').catch(noneYet),
      request<Plan>('GET', '/api/map/plan'),
      request<{ edits: Edit[] }>('GET', '/api/edits'),
    ]);
    if (mine < this.homeShown) {
      return;
    }
    this.homeShown = mine;
    this.state.plan = plan;
    this.state.edits = changes.edits;
    this.state.home = home;
    this.state.keyframes = map.keyframes;
    this.tell('home');
  }

  async refreshDevices(): Promise<void> {
    this.state.devices = (await request<{ devices: Device[] }>('GET', '/api/devices')).devices;
    this.tell('devices');
  }

  async refreshRecognitions(): Promise<void> {
    const answer = await request<{ recognitions: Recognition[] }>('GET', '/api/recognitions');
    this.state.recognitions = answer.recognitions;
    this.tell('recognitions');
  }

  // What the socket tells meanwhile is newer than the answer may be.
  async refreshJob(): Promise<void> {
    const told = this.jobsTold;
    const job = await request<Job | { state: 'none' }>('GET', '/api/job');
    if (told !== this.jobsTold) {
      return;
    }
    this.state.job = job.state === 'none' ? null : (job as Job);
    this.tell('job');
  }

  async refreshAll(): Promise<void> {
    await Promise.all([
      this.refreshHome(), this.refreshDevices(), this.refreshRecognitions(), this.refreshJob(),
    ]);
  }

  setOnline(online: boolean): void {
    if (online !== this.state.online) {
      this.state.online = online;
      this.tell('online');
    }
  }

  // What was true while this page watched.
  forgetWatched(): void {
    this.state.watched.clear();
    this.tell('watched');
  }

  // What the socket told before it was lost, and tells anew when it is back.
  forgetTold(): void {
    this.state.recording = null;
    this.state.seen.clear();
    this.tell('recording');
    this.tell('seen');
    this.forgetWatched();
  }

  // What the socket said.
  receive(message: FromComputer): void {
    switch (message.type) {
      case 'home':
        void this.refreshHome().catch(() => undefined); // told again by the next change
        void this.refreshRecognitions().catch(() => undefined); // forgotten with a room or a walk
        break;
      case 'job': {
        this.jobsTold += 1;
        const isTold = this.state.job?.kind === message.kind && this.state.job.state === message.state;
        this.state.job = message;
        this.tell('job');
        if (message.state !== 'running' && !isTold) {
          void this.refreshHome().catch(() => undefined);
        }
        break;
      }
      case 'recording':
        this.state.recording = message.state === 'none' ? null : message;
        this.tell('recording');
        break;
      case 'device':
        this.receiveDevice(message);
        break;
      case 'led_walk':
        if (message.t >= (this.state.watched.get(message.device)?.t ?? -Infinity)) {
          this.state.watched.set(message.device, { ...message, received: performance.now() });
          this.tell('watched');
        }
        break;
      default: // of interest to devices only
        break;
    }
  }

  private receiveDevice(message: DeviceSeen): void {
    const known = this.state.devices.find((device) => device.device === message.device);
    const told = this.state.seen.get(message.device);
    this.state.seen.set(message.device, message);
    this.tell('seen');
    if (!message.online && this.state.watched.delete(message.device)) {
      this.tell('watched');
    }
    const isUnpaired = known?.online === true && !message.online; // perhaps
    if (known && known.online !== message.online) {
      known.online = message.online;
      this.tell('devices');
    }
    if (!known || isUnpaired) {
      void this.refreshDevices().catch(() => undefined);
    }
    if (message.seen?.verdict !== told?.seen?.verdict || message.seen?.room !== told?.seen?.room) {
      void this.refreshRecognitions().catch(() => undefined);
    }
  }

  private tell(topic: Topic): void {
    for (const { topics, run } of this.listeners) {
      if (topics.includes(topic)) {
        try {
          run();
        } catch (error) {
          console.error(error); // the other parts of the page are shown all the same
        }
      }
    }
  }
}

// A home without a map has no key-frames.
function noneYet(error: unknown): { keyframes: Keyframe[] } {
  if (error instanceof ApiError && (error.status === 404 || error.status === 409)) {
    return { keyframes: [] };
  }
  throw error;
}
