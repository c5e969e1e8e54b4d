// The stand-in's requests: docs/protocol.md, "Requests".
import type { ServerResponse } from 'node:http';

import type { Edit, Job, JobState, Role, RoomRange, Thing } from '../src/shared/protocol';
import { drawnRoom } from './drawn_picture';
import { makeCloud, roomOfKeyframe } from './made_up_home';
import type { StandInServer } from './stand_in_server';

interface Call {
  server: StandInServer;
  parts: string[]; // what the pattern caught
  body: Buffer;
  role: Role | null;
  response: ServerResponse;
}
type Handler = (call: Call) => object | Buffer;

class Refusal extends Error {
  constructor(readonly status: number, message: string, readonly key?: string) {
    super(message);
  }
}

export const kStaffPassword = 'correct horse battery';
export const kSecret = 'AbCdEfGhIjKlMnOpQr_-12';

// Sentences of roomwise/guide/messages, chosen by hand for the made-up home.
export const kSaidOfWay = ['To the microwave: about 6 metres. Turn left.'];
export const kSaidAlong = [
  'Straight on, 1 metre to the door.', 'In 1 metre: turn left.', 'Turn left.', 'Straight on, 3 metres.', 'In 2 metres: turn right.', 'Turn right.',
  'Straight on, 3 metres to the microwave.', 'You are there: the microwave on your left, in reach. At hip height.',
];
export const kSaidWithoutPlace = ['I do not know this place.'];

const kRoutes: [string, RegExp, Role | '-', Handler][] = [
  ['GET', /^\/health$/, '-', () => ({ status: 'ok' })],
  ['POST', /^\/api\/pair$/, '-', pair],
  ['GET', /^\/api\/me$/, 'device', ({ role }) => ({ device: role === 'helper' ? 1 : 3, name: role === 'helper' ? 'Kitchen tablet' : "Anna's phone", role })],
  ['POST', /^\/api\/leave$/, 'device', ({ server }) => (server.state.unpairAll(), {})],
  ['GET', /^\/api\/staff\/me$/, '-', ({ server }) => staffOf(server)],
  ['POST', /^\/api\/staff\/sign-in$/, '-', ({ server, body }) => {
    const { name, password } = json<{ name: string; password: string }>(body);
    if (name !== 'anna' || password !== kStaffPassword) {
      throw new Refusal(401, 'the name or the password is wrong');
    }
    server.state.staff = name;
    return staffOf(server);
  }],
  ['POST', /^\/api\/staff\/sign-out$/, '-', ({ server }) => ((server.state.staff = null), {})],
  ['GET', /^\/api\/home$/, 'device', ({ server }) => server.state.home],
  ['DELETE', /^\/api\/home$/, 'helper', forgetHome],
  ['GET', /^\/api\/devices$/, 'helper', ({ server }) => ({ devices: server.state.devices })],
  ['PUT', /^\/api\/devices\/(\d+)$/, 'helper', ({ server, parts, body }) => {
    const device = server.state.devices.find((one) => one.device === Number(parts[0]));
    if (!device) {
      throw new Refusal(404, `there is no device ${parts[0]}`);
    }
    device.name = json<{ name: string }>(body).name;
    return {};
  }],
  ['DELETE', /^\/api\/devices\/(\d+)$/, 'helper', ({ server, parts }) => {
    server.state.devices = server.state.devices.filter((one) => one.device !== Number(parts[0]));
    return {};
  }],
  ['POST', /^\/api\/codes$/, 'helper', makeCode],
  ['GET', /^\/api\/authority$/, '-', () => (
    { name: 'Roomwise, home of flat (3f9c2a)', fingerprint: 'AB:12:'.repeat(16).slice(0, -1), ends: 2_400_000_000, file: '/authority.crt' })],
  ['GET', /^\/api\/map\/keyframes$/, 'helper', ({ server }) => ({ keyframes: server.state.keyframes })],
  ['GET', /^\/api\/map\/cloud$/, 'helper', ({ server }) => {
    if (server.state.keyframes.length === 0) {
      throw new Refusal(503, 'the map is not ready yet; try again soon');
    }
    return makeCloud('coarse');
  }],
  ['GET', /^\/api\/map\/cloud\/fine$/, 'helper', () => makeCloud('fine')],
  ['GET', /^\/api\/keyframes\/(\d+)\/picture$/, 'helper', ({ parts }) => drawnRoom(roomOfKeyframe(Number(parts[0])), Number(parts[0]))],
  ['PUT', /^\/api\/recordings\/(\d+)\/rooms$/, 'helper', nameRanges],
  ['DELETE', /^\/api\/recordings\/(\d+)$/, 'helper', ({ server, parts }) => {
    const { home } = server.state;
    home.recordings = home.recordings.filter((one) => one.id !== Number(parts[0]));
    server.state.keyframes = server.state.keyframes.filter((one) => one.recording !== Number(parts[0]));
    return changed(server);
  }],
  ['PUT', /^\/api\/rooms\/([^/]+)$/, 'helper', changeRoom],
  ['DELETE', /^\/api\/rooms\/([^/]+)$/, 'helper', ({ server, parts }) => {
    const { home } = server.state;
    const name = parts[0] ?? '';
    const [rooms, ranges] = [home.rooms, home.recordings.map((one) => one.ranges)];
    home.rooms = rooms.filter((room) => room.name !== name);
    home.recordings.forEach((one) => (one.ranges = one.ranges.filter((range) => range.room !== name)));
    const { edit } = edited(server, { what: 'remove room', room: name }, () => {
      home.rooms = rooms;
      home.recordings.forEach((one, i) => (one.ranges = ranges[i] ?? []));
      home.to_erase.rooms = home.to_erase.rooms.filter((one) => one.name !== name);
    }) as { edit: number };
    home.to_erase.rooms.push({ name, edit });
    return {};
  }],
  ['PUT', /^\/api\/things\/(\d+)$/, 'helper', ({ server, parts, body }) => {
    const thing = thingOf(server, Number(parts[0]));
    const before = { name: thing.name, by_hand: thing.by_hand };
    Object.assign(thing, { name: json<{ name: string }>(body).name, by_hand: true });
    return edited(server, { what: 'rename thing', old_name: before.name, name: thing.name }, () => Object.assign(thing, before));
  }],
  ['DELETE', /^\/api\/things\/(\d+)$/, 'helper', ({ server, parts }) => {
    const thing = thingOf(server, Number(parts[0]));
    const before = server.state.home.things;
    server.state.home.things = before.filter((one) => one !== thing);
    return edited(server, { what: 'remove thing', old_name: thing.name }, () => (server.state.home.things = before));
  }],
  ['GET', /^\/api\/map\/plan$/, 'helper', ({ server }) => server.state.plan],
  ['POST', /^\/api\/ask$/, 'helper', ({ body }) => {
    const { text, place } = json<{ text: string; place?: [number, number] }>(body);
    const isWay = /take me/i.test(text) && place;
    return {
      said: isWay ? kSaidOfWay : kSaidWithoutPlace,
      along: isWay ? kSaidAlong : [],
      way: isWay ? [place, [4, 1.4], [1.5, 1.2], [1, 3.8]] : [], goal: isWay ? [0.5, 4.1] : null,
    };
  }],
  ['GET', /^\/api\/coverage$/, 'helper', ({ server }) => {
    if (!server.state.coverage) {
      throw new Refusal(503, 'the map is being made; what is missing is told when it is ready');
    }
    return server.state.coverage;
  }],
  ['GET', /^\/api\/edits$/, 'helper', ({ server }) => ({ edits: server.state.edits.map(({ undo: _, ...edit }) => edit).reverse() })],
  ['POST', /^\/api\/edits$/, 'helper', makeEdit],
  ['DELETE', /^\/api\/edits\/(\d+)$/, 'helper', ({ server, parts }) => {
    const last = server.state.edits.at(-1);
    if (last?.edit !== Number(parts[0])) {
      throw new Refusal(409, 'something later is about the same; undo that first');
    }
    server.state.edits.pop();
    last.undo();
    return changed(server);
  }],
  ['POST', /^\/api\/learn$/, 'helper', ({ server }) => {
    if (server.state.job?.state === 'running') {
      throw new Refusal(409, 'a job is running; stop it or wait for its end');
    }
    tellJob(server, 'running', 0, 'looking at pictures');
    return {};
  }],
  ['GET', /^\/api\/job$/, 'helper', ({ server }) => server.state.job ?? { state: 'none' }],
  ['POST', /^\/api\/job\/go_on$/, 'helper', ({ server }) => (tellJob(server, 'running', 0.4, 'mapping', 'map'), {})],
  ['POST', /^\/api\/erase$/, 'helper', ({ server }) => {
    server.state.home.to_erase = { walks: [], rooms: [], owed: false };
    server.state.edits = server.state.edits.filter(({ what }) => what !== 'take walk away' && what !== 'remove room');
    return changed(server);
  }],
  ['POST', /^\/api\/job\/stop$/, 'helper', ({ server }) => (tellJob(server, 'stopped', 0.4, 'stopped'), {})],
  ['POST', /^\/api\/test$/, 'helper', testPicture],
  ['GET', /^\/api\/recognitions$/, 'helper', ({ server }) => ({ recognitions: server.state.recognitions })],
  ['GET', /^\/api\/recognitions\/(\d+)\/picture$/, 'helper', ({ parts }) => drawnRoom(parts[0] === '12' ? 'kitchen' : 'corridor', Number(parts[0]))],
  ['GET', /^\/api\/photos$/, 'helper', ({ server }) => ({
    rooms: [...server.state.photos].map(([room, photos]) => ({ room, photos })), wanted: kWantedPhotos,
  })],
  ['POST', /^\/api\/rooms\/([^/]+)\/photos$/, 'helper', ({ server, parts, body }) => {
    if (body.readUInt16BE(0) !== 0xffd8) {
      throw new Refusal(409, 'this is no picture');
    }
    const room = parts[0] ?? '';
    const photos = (server.state.photos.get(room) ?? 0) + 1;
    server.state.photos.set(room, photos);
    return { room, photos, wanted: kWantedPhotos };
  }],
  ['DELETE', /^\/api\/rooms\/([^/]+)\/photos$/, 'helper', ({ server, parts }) => (server.state.photos.delete(parts[0] ?? ''), {})],
  ['GET', /^\/api\/uploads$/, 'helper', ({ server }) => ({ uploads: server.state.uploads })],
  ['POST', /^\/api\/uploads$/, 'helper', beginUpload],
  ['PUT', /^\/api\/uploads\/([^/]+)\/(\d+)$/, 'helper', putPiece],
  ['POST', /^\/api\/uploads\/([^/]+)\/map$/, 'helper', ({ server }) => {
    server.state.uploads = [];
    tellJob(server, 'running', 0, 'unpacking', 'map');
    return {};
  }],
  ['DELETE', /^\/api\/uploads\/([^/]+)$/, 'helper', ({ server, parts }) => {
    server.state.uploads = server.state.uploads.filter((one) => one.upload !== parts[0]);
    return {};
  }],
  ['POST', /^\/api\/recording$/, 'helper', startRecording],
  ['POST', /^\/api\/recording\/stop$/, 'helper', ({ server }) => {
    if (server.state.recording?.state !== 'recording') {
      throw new Refusal(409, 'nothing is being recorded');
    }
    tellRecording(server, 'saved', 17);
    tellJob(server, 'running', 0, 'mapping', 'map');
    return {};
  }],
];

function thingOf(server: StandInServer, id: number): Thing {
  const thing = server.state.home.things.find((one) => one.id === id);
  if (!thing) {
    throw new Refusal(409, 'this home has no such thing any more; look at it anew');
  }
  return thing;
}

// Keeps a change, so that it can be undone.
function edited(server: StandInServer, edit: Partial<Edit>, undo: () => void): object {
  const number = (server.state.edits.at(-1)?.edit ?? 0) + 1;
  server.state.edits.push({
    edit: number, what: 'note', made: 1_760_000_000, by: 'Kitchen tablet', name: '', old_name: '', note: '', room: '', other_room: '',
    type: '', without_effect: '', is_final: false, undo_first: '', ...edit, undo,
  });
  changed(server);
  return { edit: number };
}

interface AskedEdit extends Partial<Edit> {
  thing?: number;
  double?: number;
  walk?: number;
  position?: [number, number];
  line?: [number, number][];
}

// As far as the tests need it.
function makeEdit({ server, body }: Call): object {
  const asked = json<AskedEdit>(body);
  const { home } = server.state;
  const things = home.things;
  const said = { name: asked.name ?? '', note: asked.note ?? '', room: asked.room ?? '', other_room: asked.other_room ?? '' };
  switch (asked.what) {
    case 'add thing':
      home.things = [...things, {
        id: 100 + server.state.edits.length, ...said, room: asked.room ?? 'kitchen', size: [0.3, 0.3, 0.3], probability: 1,
        position: asked.position ? [...asked.position, 0.8] : [1.5, 2.2, 0.8], keyframe: 0, box: [0, 0, 0, 0], by_hand: true, added: true,
      }];
      return edited(server, { what: asked.what, ...said }, () => (home.things = things));
    case 'note': {
      const thing = thingOf(server, asked.thing ?? -1);
      const { note } = thing;
      thing.note = said.note;
      return edited(server, { what: asked.what, ...said, old_name: thing.name }, () => (thing.note = note));
    }
    case 'merge things': {
      const [kept, double] = [thingOf(server, asked.thing ?? -1), thingOf(server, asked.double ?? -1)];
      home.things = things.filter((one) => one !== double);
      return edited(server, { what: asked.what, old_name: kept.name, name: double.name }, () => (home.things = things));
    }
    case 'take walk away': {
      const { recordings } = home;
      const walk = recordings.find(({ id }) => id === asked.walk);
      if (!walk) {
        throw new Refusal(409, `this home has no walk ${asked.walk}`);
      }
      home.recordings = recordings.filter((one) => one !== walk);
      const made = edited(server, { what: asked.what, name: walk.name }, () => {
        home.recordings = recordings;
        home.to_erase.walks = [];
      }) as { edit: number };
      home.to_erase.walks = [{ id: walk.id, name: walk.name, edit: made.edit }];
      return made;
    }
    case 'divide room': {
      if (asked.line?.length !== 2) {
        throw new Refusal(409, "'line' must be two points");
      }
      const { rooms } = home;
      home.rooms = [...rooms, { name: said.other_room, type: said.other_room, floor_m2: 4, middle: [2, 4] }];
      return edited(server, { what: asked.what, ...said }, () => (home.rooms = rooms));
    }
    default:
      throw new Refusal(409, `'${asked.what}' is none`);
  }
}

export function answerApi(
  server: StandInServer, method: string, path: string, body: Buffer, role: Role | null, response: ServerResponse,
): void {
  try {
    const fitting = kRoutes.filter(([, pattern]) => pattern.test(path));
    const route = fitting.find(([of]) => of === method);
    if (!route) {
      throw new Refusal(fitting.length > 0 ? 405 : 404, 'there is nothing here');
    }
    const [, pattern, wanted, handler] = route;
    if (wanted !== '-' && !role) {
      throw new Refusal(401, 'this device is not paired; open /pair');
    }
    if (wanted === 'helper' && role !== 'helper') {
      throw new Refusal(403, 'this is for helpers');
    }
    if (method !== 'GET') {
      server.state.requests.push(`${method} ${path} ${body.length < 2000 ? body.toString() : `(${body.length} bytes)`}`.trim());
    }
    const parts = (pattern.exec(path) ?? []).slice(1);
    send(response, 200, handler({ server, parts, body, role, response }));
  } catch (error) {
    send(response, error instanceof Refusal ? error.status : 500, { error: (error as Error).message, ...(error instanceof Refusal && error.key ? { message: error.key } : {}) });
  }
}

function send(response: ServerResponse, status: number, answer: object | Buffer): void {
  const isJson = !Buffer.isBuffer(answer);
  const isPng = !isJson && answer.subarray(1, 4).toString() === 'PNG';
  response.writeHead(status, { 'Content-Type': isJson ? 'application/json' : isPng ? 'image/png' : 'application/octet-stream' });
  response.end(isJson ? JSON.stringify(answer) : answer);
}

function json<Body>(body: Buffer): Body {
  return JSON.parse(body.toString()) as Body;
}

function changed(server: StandInServer): object {
  const { type: _, version: __, ...members } = server.state.welcome('helper');
  server.tell('helper', { ...members, type: 'home' });
  server.tell('device', { ...members, type: 'home' });
  return {};
}

function staffOf(server: StandInServer): object {
  if (server.state.staff === null) {
    throw new Refusal(401, 'sign in first');
  }
  return { name: server.state.staff, homes: [{ name: 'flat-1', role: 'helper' }, { name: 'flat-2', role: 'device' }] };
}

function pair({ server, body, response }: Call): object {
  const { code, secret, name } = json<{ code?: string; secret?: string; name: string }>(body);
  if (Buffer.byteLength(name) > 64) {
    throw new Refusal(400, "'name' must have 1 to 64 bytes");
  }
  if (secret ? secret !== kSecret : code !== server.state.code) {
    throw new Refusal(401, 'this code does not hold; ask for a new one', 'code_over');
  }
  const role = server.state.codeRole;
  response.setHeader('Set-Cookie', `roomwise=${server.state.pair(role)}; Secure; HttpOnly; SameSite=Strict; Path=/`);
  server.state.devices.push({ device: 9, name, role, paired: 1_760_000_000, last_seen: 1_760_000_000, online: false });
  return { role, device: 9 };
}

function makeCode({ server, body }: Call): object {
  server.state.codeRole = json<{ role: Role }>(body).role;
  // Finder patterns and a chequered inside: not readable, but of the right look.
  const finder = (x: number, y: number): boolean => Math.max(Math.abs(x - 3), Math.abs(y - 3)) !== 2;
  const qr = Array.from({ length: 25 }, (_, y) => Array.from({ length: 25 }, (__, x) => {
    for (const [left, top] of [[0, 0], [18, 0], [0, 18]] as const) {
      if (x >= left - 1 && x < left + 8 && y >= top - 1 && y < top + 8) {
        return x >= left && x < left + 7 && y >= top && y < top + 7 && finder(x - left, y - top) ? '1' : '0';
      }
    }
    return (x * 7 + y * 11 + x * y) % 3 === 0 ? '1' : '0';
  }).join(''));
  return { code: server.state.code, valid_s: 300, digits_wait_s: 0, address: `https://roomwise.local:8443/pair#${server.state.code}`, qr };
}

function forgetHome({ server, body }: Call): object {
  const { home } = server.state;
  if (json<{ really: string }>(body).really !== home.name) {
    throw new Refusal(400, `'really' must be the home's name, '${home.name}'`);
  }
  Object.assign(home, { learned: null, rooms: [], doorways: [], things: [], recordings: [], changes: null });
  server.state.keyframes = [];
  server.state.recognitions = [];
  return changed(server);
}

function nameRanges({ server, parts, body }: Call): object {
  const recording = server.state.home.recordings.find((one) => one.id === Number(parts[0]));
  if (!recording) {
    throw new Refusal(404, 'there is no such recording');
  }
  recording.ranges = json<{ ranges: RoomRange[] }>(body).ranges;
  for (const { room } of recording.ranges) {
    if (!server.state.home.rooms.some((one) => one.name === room)) {
      server.state.home.rooms.push({ name: room, type: null, floor_m2: null, middle: null });
    }
  }
  return changed(server);
}

function changeRoom({ server, parts, body }: Call): object {
  const { home } = server.state;
  const room = home.rooms.find((one) => one.name === parts[0]);
  const { name, type } = json<{ name?: string; type?: string }>(body);
  if (!room) {
    throw new Refusal(404, `there is no room '${parts[0]}'`);
  }
  if (name && name !== room.name && home.rooms.some((one) => one.name === name)) {
    throw new Refusal(409, `there is a room '${name}' already; choose another name`);
  }
  const old = room.name;
  room.name = name ?? old;
  room.type = type ?? room.type;
  home.things.forEach((thing) => (thing.room = thing.room === old ? room.name : thing.room));
  home.doorways.forEach((doorway) => (doorway.rooms = doorway.rooms.map((one) => (one === old ? room.name : one))));
  return changed(server);
}

function testPicture({ body }: Call): object {
  const isPicture = body.readUInt16BE(0) === 0xffd8 || body.subarray(1, 4).toString() === 'PNG';
  if (!isPicture) {
    throw new Refusal(415, 'this is no picture; send a JPEG, PNG or WebP');
  }
  return {
    verdict: 'room', room: 'kitchen', probability: 0.94, known: 0.99, why: 'the picture looks like the kitchen (0.94)',
    rooms: [{ room: 'kitchen', probability: 0.94 }, { room: 'corridor', probability: 0.04 }, { room: 'bathroom', probability: 0.02 }],
  };
}

const kPieceBytes = 1000;
const kWantedPhotos = 3;

function beginUpload({ server, body }: Call): object {
  const { name, bytes } = json<{ name: string; bytes: number }>(body);
  if (bytes > 1_000_000) {
    throw new Refusal(409, "the computer's disk has room for 1 MB more");
  }
  let upload = server.state.uploads.find((one) => one.name === name && one.bytes === bytes);
  if (!upload) {
    upload = { upload: 'u1', name, bytes, offset: 0, chunk_bytes: kPieceBytes };
    server.state.uploads.push(upload);
    server.state.uploaded = Buffer.alloc(0);
  }
  return upload;
}

function putPiece({ server, parts, body }: Call): object {
  const upload = server.state.uploads.find((one) => one.upload === parts[0]);
  if (!upload) {
    throw new Refusal(404, 'there is no such upload');
  }
  if (server.state.failsPieces > 0) {
    server.state.failsPieces -= 1;
    throw new Refusal(503, 'the computer is busy');
  }
  server.state.uploaded = Buffer.concat([server.state.uploaded.subarray(0, Number(parts[1])), body]);
  upload.offset = server.state.uploaded.length;
  return upload;
}

function startRecording({ server, body }: Call): object {
  const { device, name } = json<{ device: number; name: string }>(body);
  if (!server.state.devices.find((one) => one.device === device)?.online) {
    throw new Refusal(409, 'this device is not connected');
  }
  tellRecording(server, 'recording', 0, name, device);
  return {};
}

export function tellRecording(
  server: StandInServer, state: 'recording' | 'saved' | 'failed', frames: number, name = server.state.recording?.name ?? 'walk',
  device = server.state.recording?.device ?? 3,
): void {
  server.state.recording = { type: 'recording', device, state, name, frames, text: '' };
  server.tell('helper', server.state.recording);
  server.tell('device', server.state.recording);
}

export function tellJob(
  server: StandInServer, state: JobState, fraction: number, stage: string, kind: Job['kind'] = server.state.job?.kind ?? 'learn',
): void {
  server.state.job = { type: 'job', kind, state, stage, fraction, left_s: state === 'running' ? 70 : null, text: '', message: state === 'stopped' ? 'stopped' : '', values: {} };
  server.tell('helper', server.state.job);
}
