// A home of four rooms that nobody lives in: what the computer would answer of it.
import type { Coverage, Home, Keyframe, Plan, Point, RoomRange, Thing, WatchedDevice, WatchedWalk } from '../src/shared/protocol';

// Rooms as rectangles on the floor, metres: x, y, width, depth.
const kRooms: Record<string, [number, number, number, number]> = {
  corridor: [0, 0, 6, 1.5],
  kitchen: [0, 1.5, 3, 3.2],
  bathroom: [3, 1.5, 2, 2.4],
  bedroom: [5, 1.5, 3.6, 3.2],
};
const kWallHeight = 2.5;
const kFramesPerKeyframe = 4;
const kKeyframesPerRoom = 6;

export function makeHome(): Home {
  return {
    name: 'Our flat',
    learned: { pictures: 310, network: 'roomwise-compact-2' },
    rooms: Object.entries(kRooms).map(([name, [x, y, width, depth]]) => ({
      name, type: name, floor_m2: Math.round(width * depth * 10) / 10, middle: [x + width / 2, y + depth / 2],
    })),
    doorways: [
      { rooms: ['corridor', 'kitchen'], middle: [1.5, 1.5], door: true },
      { rooms: ['bathroom', 'corridor'], middle: [4, 1.5], door: true },
      { rooms: ['bedroom', 'corridor'], middle: [5.5, 1.5], door: true },
    ],
    things: kThings.map((thing) => ({ ...thing })),
    recordings: [{
      id: 1, name: 'walk', frames: 96, keyframes: 24, finished: true, recorded: new Date(2026, 4, 3, 12, 30).getTime() / 1000, camera: null,
      ranges: kRanges.map((range) => ({ ...range })),
    }],
    room_types: ['bathroom', 'bedroom', 'corridor', 'dining room', 'kitchen', 'living room', 'office'],
    walk_waits: false,
    to_erase: { walks: [], rooms: [], owed: false },
    changes: null,
  };
}

export function makePlan(): Plan {
  return {
    rooms: Object.entries(kRooms).map(([name, [x, y, width, depth]]) => ({
      name, polygons: [[[[x, y], [x + width, y], [x + width, y + depth], [x, y + depth]] as Point[]]],
    })),
    doors: [
      { rooms: ['corridor', 'kitchen'], middle: [1.5, 1.5], width_m: 0.8, door: true },
      { rooms: ['bathroom', 'corridor'], middle: [4, 1.5], width_m: 0.8, door: true },
      { rooms: ['bedroom', 'corridor'], middle: [5.5, 1.5], width_m: 0.9, door: true },
    ],
  };
}

// Of somebody who is led from the kitchen to the bed, at a time of the computer's clock.
export function madeUpWalk(t: number, more: Partial<WatchedDevice> = {}, now: Partial<WatchedWalk> = {}): WatchedDevice {
  return {
    type: 'led_walk', device: 3, name: "Anna's phone", t, may_watch: true,
    walk: {
      language: 'en', goal: 'bed', state: 'on_way', person: { t: t - 100, x: 1.9, y: 2.1, heading_degrees: -120, sigma_m: 0.12 }, left_m: 6.43,
      way: [[1.9, 2.1], [1.5, 1.5], [1.7, 0.9], [5.3, 0.9], [5.5, 1.5], [6.3, 2.7]],
      said: [{ t: 400, text: 'To the bed: about 6 metres.' }, { t: 900, text: 'Turn right, to the door.' }], ...now,
    },
    ...more,
  };
}

// One walk at noon, from whose middle the bedroom was seen; a corner of the bedroom and the kitchen's end are not known.
export function makeCoverage(noon_s: number): Coverage {
  const missing = (more: Partial<Coverage['missing'][0]>): Coverage['missing'][0] => (
    { what: 'floor', room: null, walk: null, pictures: 0, wanted: null, floor: null, ...more });
  return {
    missing: [
      missing({ what: 'names', walk: 1, pictures: 6 }),
      missing({ what: 'pictures', room: 'bedroom', pictures: 0, wanted: 10 }),
      missing({ what: 'more pictures', room: 'bathroom', pictures: 6, wanted: 30 }),
      missing({ what: 'second walk', room: 'kitchen', walk: 1, pictures: 6 }),
      missing({ room: 'kitchen', floor: { place: [2.6, 4.4], length_m: 0.9, unseen: true, beside: 'refrigerator' } }),
      missing({ room: 'bedroom', floor: { place: [8.3, 4.4], length_m: 1.24, unseen: false, beside: null } }),
    ],
    rooms: ['bathroom', 'bedroom', 'corridor', 'kitchen'].map((room) => (
      { room, pictures: room === 'bedroom' ? 0 : 6, walks: room === 'bedroom' ? [] : [{ walk: 1, pictures: 6, time: noon_s }] })),
    floor_known: true,
  };
}

const thing = (
  id: number, name: string, room: string, position: Thing['position'], size: Thing['size'], probability: number,
): Thing => ({ id, name, room, position, size, probability, keyframe: id, box: [40, 60, 120, 90], by_hand: false, added: false, note: '' });

const kThings: Thing[] = [
  thing(0, 'microwave', 'kitchen', [0.4, 4.3, 1.2], [0.5, 0.4, 0.3], 0.93),
  thing(1, 'stove', 'kitchen', [1.2, 4.35, 0.45], [0.6, 0.6, 0.9], 0.97),
  thing(2, 'refrigerator', 'kitchen', [2.6, 4.3, 0.9], [0.6, 0.65, 1.8], 0.98),
  thing(3, 'dining table', 'kitchen', [1.6, 2.7, 0.38], [1.2, 0.8, 0.75], 0.88),
  thing(4, 'toilet', 'bathroom', [4.6, 3.5, 0.4], [0.4, 0.6, 0.8], 0.96),
  thing(5, 'washbasin', 'bathroom', [3.4, 3.6, 0.8], [0.6, 0.45, 0.2], 0.71),
  thing(6, 'bed', 'bedroom', [7.4, 3.5, 0.3], [1.6, 2, 0.6], 0.99),
  thing(7, 'wardrobe', 'bedroom', [5.4, 4.3, 1], [0.8, 0.6, 2], 0.9),
  thing(8, 'lamp', 'bedroom', [8.3, 4.4, 0.7], [0.3, 0.3, 1.4], 0.64),
  thing(9, 'shelf', 'corridor', null, [0.8, 0.3, 1.8], 0.82), // seen, but not placed on the map
];

const kWalk = ['corridor', 'kitchen', 'bathroom', 'bedroom'];
const kRanges: RoomRange[] = kWalk.slice(0, 3).map((room, i) => {
  const frames = kKeyframesPerRoom * kFramesPerKeyframe;
  return { first: i * frames, last: (i + 1) * frames - 1, room };
});

// A walk through the rooms in a row; the bedroom has not been named on it yet.
export function makeKeyframes(): Keyframe[] {
  return kWalk.flatMap((room, r) => {
    const [x, y, width, depth] = kRooms[room] as [number, number, number, number];
    return Array.from({ length: kKeyframesPerRoom }, (_, i): Keyframe => {
      const id = r * kKeyframesPerRoom + i;
      const along = (i + 0.5) / kKeyframesPerRoom;
      const turn = 0.6 * Math.sin(id);
      return {
        id, frame: id * kFramesPerKeyframe, time_s: id * 1.3, recording: 1,
        room: kRanges[r] ? room : null,
        position: [x + width * (0.25 + 0.5 * along), y + depth * (0.35 + 0.3 * Math.sin(3 * along)), 1.4],
        // Of a camera that looks along the level (z forward, y down), turned by `turn`.
        rotation_xyzw: [-0.5 + turn / 4, 0.5, -0.5, 0.5],
      };
    });
  });
}

export function roomOfKeyframe(id: number): string {
  return kWalk[Math.floor(id / kKeyframesPerRoom)] ?? 'corridor';
}

// Points on floors, walls and things: x, y, z as floats, r, g, b, 255. About as many as a large home has.
export function makeCloud(how: 'coarse' | 'fine'): Buffer {
  const [perRoom, perThing] = how === 'coarse' ? [4000, 800] : [20_000, 4000];
  const points: number[][] = [];
  const colours = [[205, 190, 160], [220, 205, 170], [170, 205, 215], [215, 195, 212]];
  let state = 7;
  const random = (): number => {
    state = (Math.imul(state, 1664525) + 1013904223) >>> 0;
    return state / 2 ** 32;
  };
  Object.values(kRooms).forEach(([x, y, width, depth], r) => {
    const [red, green, blue] = colours[r] as [number, number, number];
    for (let i = 0; i < perRoom; i += 1) {
      const shade = 0.85 + 0.15 * random();
      const [u, v] = [x + width * random(), y + depth * random()];
      points.push([u, v, 0, 150 * shade, 120 * shade, 95 * shade]);
      const wall: number[] = i % 2 === 0
        ? [u, i % 4 === 0 ? y : y + depth, kWallHeight * random()]
        : [i % 4 === 1 ? x : x + width, v, kWallHeight * random()];
      points.push([...wall, red * shade, green * shade, blue * shade]);
    }
  });
  for (const { position, size, id } of kThings) {
    for (let i = 0; position && i < perThing; i += 1) {
      const place = position.map((middle, axis) => middle + (size[axis] ?? 0) * (random() - 0.5));
      const axis = i % 3;
      place[axis] = (position[axis] ?? 0) + (size[axis] ?? 0) * (i % 2 === 0 ? 0.5 : -0.5);
      points.push([...place, 90 + 15 * id, 110, 150 - 12 * id]);
    }
  }
  const bytes = Buffer.alloc(16 * points.length);
  points.forEach(([x = 0, y = 0, z = 0, r = 0, g = 0, b = 0], i) => {
    bytes.writeFloatLE(x, 16 * i);
    bytes.writeFloatLE(y, 16 * i + 4);
    bytes.writeFloatLE(z, 16 * i + 8);
    bytes.set([r, g, b, 255], 16 * i + 12);
  });
  return bytes;
}
