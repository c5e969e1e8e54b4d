// What the stand-in remembers: the home, who is paired, what is going on.
import { randomUUID } from 'node:crypto';

import type { UploadState } from '../src/shared/upload';
import type { Coverage, Device, Edit, Job, NotRecorded, Recognition, RecordingState, Role, Welcome } from '../src/shared/protocol';
import { makeCoverage, makeHome, makeKeyframes, makePlan } from './made_up_home';

const kDay = 86_400;
const kNoon = 1_760_000_000;

export class StandInState {
  readonly code = '314159';
  staff: string | null = null; // who has signed in
  codeRole: Role = 'device';
  home = makeHome();
  keyframes = makeKeyframes();
  plan = makePlan();
  coverage: Coverage | null = makeCoverage(new Date(2026, 4, 3, 12, 30).getTime() / 1000); // null: the map is not ready
  edits: (Edit & { undo: () => void })[] = []; // the newest last
  job: Job | null = null;
  recording: RecordingState | null = null;
  photos = new Map<string, number>(); // by room
  uploads: UploadState[] = [];
  uploaded = Buffer.alloc(0); // the bytes of the newest
  failsPieces = 0; // so many are answered by 503
  readonly requests: string[] = []; // those that change something: "PUT /api/rooms/kitchen {…}"
  devices: Device[] = [
    { device: 1, name: 'Kitchen tablet', role: 'helper', paired: kNoon - 30 * kDay, last_seen: kNoon, online: true },
    { device: 3, name: "Anna's phone", role: 'device', paired: kNoon - 20 * kDay, last_seen: kNoon - 300, online: true },
    { device: 4, name: 'Chest camera', role: 'device', paired: kNoon - 9 * kDay, last_seen: kNoon - kDay, online: false },
  ];
  recognitions: Recognition[] = [
    {
      number: 12, device: 3, name: "Anna's phone", time: kNoon - 320, verdict: 'room', room: 'kitchen',
      probability: 0.97, why: 'the pictures look like the kitchen (0.97); stove and refrigerator are seen',
    },
    {
      number: 11, device: 3, name: "Anna's phone", time: kNoon - 410, verdict: 'not sure', room: 'corridor',
      probability: 0.55, why: 'corridor (0.55) and bedroom (0.41) are too close',
    },
  ];
  private readonly tokens = new Map<string, Role>();

  pair(role: Role): string {
    const token = randomUUID();
    this.tokens.set(token, role);
    return token;
  }

  unpairAll(): void {
    this.tokens.clear();
  }

  roleOf(token: string | undefined): Role | null {
    return this.tokens.get(token ?? '') ?? null;
  }

  // What a device is told that came; each role has one device.
  recordedFor(role: Role): (RecordingState | NotRecorded)[] {
    const device = role === 'helper' ? 1 : 3;
    const now = this.recording?.state === 'recording' ? this.recording : null;
    return [
      ...(now?.device === device ? [] : [{ type: 'recording', device, state: 'none', name: '', frames: 0, text: '' } as const]),
      ...(now && (now.device === device || role === 'helper') ? [now] : []),
    ];
  }

  welcome(role: Role): Welcome {
    return {
      type: 'welcome', version: 1, home: this.home.name, role, rooms: this.home.rooms.map((room) => room.name).sort(),
      things: [...new Set(this.home.things.map((thing) => thing.name))].sort(), sees_rooms: true, sees_places: true,
      max_frame_bytes: 4_000_000,
    };
  }
}
