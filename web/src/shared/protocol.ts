// What the computer and its clients say to each other: docs/protocol.md, version 1.

export const kProtocolVersion = 1;
export const kSubprotocol = 'roomwise.1';

export type Language = 'en' | 'de' | 'es' | 'fr';
export type Distances = 'metres' | 'steps';
export type Role = 'device' | 'helper';
export type Priority = 'hazard' | 'answer' | 'notice' | 'callout';
export type Confidence = 'sure' | 'probable' | 'unsure';
export type Sound = 'answer' | 'unsure' | 'lost' | 'back' | 'alert' | 'none';
export type Verdict = 'room' | 'either' | 'not sure' | 'none of them';
export type Vector = [number, number, number];

// Times `t` are milliseconds of this device's steady clock (performance.now()).
export interface Prompt {
  type: 'prompt';
  answer_to: number | null;
  key: string;
  message: string;
  text: string;
  language: Language;
  priority: Priority;
  confidence: Confidence;
  sound: Sound;
  because: string;
  based_on_t: number | null;
  valid_until_t: number;
}

// Several of one name, in different rooms.
export interface ThingInRooms {
  thing: string;
  rooms: string[];
}

// Where the goal is of who is led and about to touch it.
export interface Aim {
  type: 'aim';
  t: number; // of the picture that tells it
  bearing_degrees: number; // from the camera's axis, positive to the left
  distance_m: number;
  valid_until_t: number;
}

export interface Welcome {
  type: 'welcome';
  version: number;
  home: string;
  role: Role;
  rooms: string[];
  things: string[];
  things_in_rooms?: ThingInRooms[]; // of the things those that must be told apart
  spots?: string[]; // that this device marked; a computer of before tells none
  sees_rooms: boolean;
  sees_places: boolean;
  max_frame_bytes: number;
}

export interface Position {
  x: number;
  y: number;
  z: number;
  heading_degrees: number;
  sigma_m: number;
}

export interface Seen {
  t: number;
  verdict: Verdict;
  room: string;
  probability: number;
  why: string;
  position: Position | null;
}

export interface RecordingState {
  type: 'recording';
  device: number; // whose frames are stored
  state: 'recording' | 'saved' | 'empty' | 'failed';
  name: string;
  frames: number;
  text: string;
}

// Told once to a device that came, where it is not recorded.
export interface NotRecorded extends Omit<RecordingState, 'state'> {
  state: 'none';
}

export type JobKind = 'prepare' | 'map' | 'learn' | 'teach' | 'erase';
export type JobState = 'running' | 'done' | 'failed' | 'stopped';

export interface Job {
  type: 'job';
  kind: JobKind;
  state: JobState;
  stage: string;
  fraction: number;
  left_s: number | null;
  text: string; // in English
  message: string; // how it ended, to be said in the page's language (job_words.ts); empty while it runs
  values: Record<string, number>; // that belong into the message
}

export interface DeviceSeen {
  type: 'device';
  device: number;
  name: string;
  online: boolean;
  seen: Seen | null;
}

// What helpers who watch see of who is led. Its times are of the computer's steady clock, for their differences alone.
export interface WatchedWalk {
  language: Language; // of what follows
  goal: string;
  state: 'on_way' | 'off_way' | 'lost' | 'by_rooms' | 'paused' | 'waiting' | 'arrived' | 'nearest' | 'ended';
  person: { t: number; x: number; y: number; heading_degrees: number; sigma_m: number } | null; // by the newest picture that told
  left_m: number | null;
  way: Point[];
  said: { t: number; text: string }[]; // the newest last
}

export interface WatchedDevice {
  type: 'led_walk';
  device: number;
  name: string;
  t: number; // of two messages the later one holds
  may_watch: boolean; // its person says so
  walk: WatchedWalk | null; // null: nobody is led, or they may not watch
}

export type FromComputer =
  | Prompt
  | Aim
  | Welcome
  | RecordingState
  | NotRecorded
  | Job
  | DeviceSeen
  | WatchedDevice
  | ({ type: 'seen' } & Seen)
  | ({ type: 'home' } & Partial<Omit<Welcome, 'type' | 'version'>>)
  | { type: 'frame'; t: number; dropped: number }
  | { type: 'error'; text: string; answer_to: number | null; t: number | null };

export interface Intrinsics {
  width: number;
  height: number;
  fx: number;
  fy: number;
  cx: number;
  cy: number;
}

// What the device knew of its motion when it took a picture.
export interface FramePose {
  source: string;
  position: Vector; // of the camera in the device's world
  rotation_xyzw: [number, number, number, number]; // from the camera (x right, y down, z forward) to that world
  up: Vector | null;
  covariance: number[] | null;
}

// What version 2 of a frame's header adds.
export interface FrameAdditions {
  version: 2;
  camera: Intrinsics | null;
  depth: { width: number; height: number } | null;
  pose: FramePose | null;
}

export interface CameraDescription {
  width: number;
  height: number;
  fx?: number; // where it is calibrated, with the others
  fy?: number;
  cx?: number;
  cy?: number;
  depth_units_per_metre?: number; // where it has depth
  lens?: string; // by which the device tells its lenses apart
}

export interface Hello {
  type: 'hello';
  version: typeof kProtocolVersion;
  name: string;
  kind: 'phone' | 'wearable' | 'page';
  camera: CameraDescription | null;
  language: Language;
  distances: Distances;
  step_m: number;
  callouts: boolean;
  may_watch: boolean; // helpers see where it is, and how somebody is led
}

// What somebody who is led may say to the guide.
export type GuideWish = 'pause' | 'resume' | 'how_far' | 'next' | 'blocked' | 'end';

export type Question =
  | { question: 'where_am_i' | 'around_me' | 'repeat' }
  | { question: 'in_words'; text: string }
  | { question: 'where_is'; thing: string; in?: string } // in that room
  | { question: 'take_me_to'; thing: string; in?: string; to?: string } // or what else the computer knows by that name; a door to that room
  | { question: 'take_me_to'; room: string }
  | { question: 'take_me_to' | 'where_is'; goal: 'way_out' }
  | { question: 'guide'; wish: GuideWish }
  | { question: 'name_room'; room: string }
  | { question: 'mark_spot' | 'forget_spot'; spot?: string }
  | { question: 'rename_spot'; spot: string; name: string }
  | { question: 'take_me_back' | 'which_spots' }
  | { question: 'show_walks' | 'hide_walks' }
  | { question: 'teach_thing' | 'stop_teaching' }
  | { question: 'name_thing'; thing: string; private?: boolean };

// Answers of requests.

export interface Me {
  device: number;
  name: string;
  role: Role;
}

export interface Room {
  name: string;
  type: string | null;
  floor_m2: number | null;
  middle: [number, number] | null;
}

export interface Doorway {
  rooms: string[];
  middle: [number, number] | null;
  door: boolean; // else the rooms are open to each other
}

export interface Thing {
  id: number;
  name: string;
  probability: number;
  room: string | null;
  position: Vector | null; // not known while the map is made ready, or on another piece of it
  size: Vector;
  keyframe: number;
  box: [number, number, number, number];
  by_hand: boolean; // a helper who was there says so
  added: boolean; // by a helper: no picture shows it
  note: string; // that is said with it; may be empty
}

// What a helper changed; members that its kind has not are empty.
export interface Edit {
  edit: number;
  what: 'add thing' | 'rename thing' | 'note' | 'move thing' | 'merge things' | 'remove thing' | 'rename room' | 'room type'
    | 'name frames' | 'remove room' | 'take walk away' | 'join rooms' | 'divide room' | 'move border' | 'draw room' | 'add door';
  made: number; // seconds since 1970
  by: string;
  name: string;
  old_name: string;
  note: string;
  room: string;
  other_room: string;
  type: string;
  without_effect: string; // why nothing comes of it now; empty: it holds
  is_final: boolean; // a room was removed for good since: it cannot be undone any more
  undo_first: string; // what must be undone before it; empty: nothing
}

export type Point = [number, number];

// The home from above, in metres; y goes up.
export interface Plan {
  right_degrees?: number; // the direction, counter-clockwise from x, that a drawing has to the right; else x
  rooms: { name: string; polygons: Point[][][] }[]; // each an outer ring and holes
  doors: { rooms: [string, string]; middle: Point; width_m: number; door: boolean }[]; // where `door` is false, open borders
}

export interface RoomRange {
  first: number;
  last: number;
  room: string;
}

export interface Recording {
  id: number;
  name: string;
  frames: number;
  keyframes: number;
  finished: boolean;
  recorded: number | null; // seconds since 1970; null where that is not known
  camera: object | null;
  ranges: RoomRange[];
}

// What goes from the home's file when its computer is switched off, or at once where somebody says so.
export interface ToErase {
  walks: { id: number; name: string; edit: number }[]; // `edit`: that it was taken away, to be undone
  rooms: { name: string; edit: number }[];
  owed: boolean; // more was forgotten, and is not erased yet
}

// What a walk found other than the walks before it.
export interface ThingChange {
  what: 'new' | 'moved' | 'shifted' | 'gone';
  name: string;
  room: string | null; // where it stands now or, gone, stood
  moved_m: number | null;
}

export interface Home {
  name: string;
  learned: { pictures: number; network: string } | null;
  rooms: Room[];
  doorways: Doorway[];
  things: Thing[];
  recordings: Recording[];
  room_types: string[];
  walk_waits: boolean; // to be mapped
  to_erase: ToErase;
  changes: { walk: number; since: number; things: ThingChange[] } | null; // of one walk: null
  storeys?: Storey[]; // of a home of several, from the lowest on; the plan draws them side by side
  stairs?: Stairs[];
}

export interface Storey {
  from_x: number | null; // where it begins on the plan; of the first null
  plan_from_level: Point; // what is added to x and y of the level frame
  floor_m: number; // height of its floor there
}

export interface Stairs {
  rooms: [string | null, string | null]; // below and above
  storeys: [number, number];
  steps: number; // 0: they could not be counted
  left_rail: boolean; // of who climbs
  right_rail: boolean;
}

// What somebody would be told who asks from a place of the plan.
export interface Trial {
  said: string[];
  along: string[]; // what who is led hears after that, if they do as they are told
  way: Point[]; // empty: they would be led nowhere
  goal: Point | null;
}

// Where floor goes on unseen, or was seen from afar.
export interface FloorGap {
  place: Point;
  length_m: number;
  unseen: boolean; // else: from afar
  beside: string | null; // the thing that stands there
}

export interface Missing {
  what: 'join' | 'names' | 'pictures' | 'more pictures' | 'second walk' | 'other light' | 'floor';
  room: string | null;
  walk: number | null;
  pictures: number; // that there are
  wanted: number | null; // that would do
  floor: FloorGap | null;
}

// What the walks have not shown yet.
export interface Coverage {
  missing: Missing[];
  rooms: { room: string; pictures: number; walks: { walk: number; pictures: number; time: number | null }[] }[];
  floor_known: boolean;
}

export interface Keyframe {
  id: number;
  frame: number; // its index in the recording
  time_s: number;
  position: Vector;
  rotation_xyzw: [number, number, number, number];
  room: string | null;
  recording: number;
  storey?: number; // of a home of several, from the lowest on
}

export interface Device {
  device: number;
  name: string;
  role: Role;
  paired: number;
  last_seen: number;
  online: boolean;
}

export interface Authority {
  name: string;
  fingerprint: string; // SHA-256, as certificates' viewers show it
  ends: number; // seconds since 1970
  file: string;
}

export interface PairingCode {
  code: string;
  valid_s: number;
  digits_wait_s: number; // somebody guesses: so long only the address is heard
  address: string;
  qr: string[];
}

export interface TestResult {
  verdict: Verdict;
  room: string;
  probability: number;
  known: number;
  why: string;
  rooms: { room: string; probability: number }[];
}

export interface Recognition {
  number: number;
  device: number;
  name: string;
  time: number;
  verdict: Verdict;
  room: string;
  probability: number;
  why: string;
}
