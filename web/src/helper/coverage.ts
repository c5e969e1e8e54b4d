// What the walks have not shown yet, as sentences and as marks on the plan. Pure.
import type { Coverage, FloorGap, Home, Missing, Plan, Point } from '../shared/protocol';
import { counted, formatNumber, formatTime, text } from '../shared/texts';
import { drawn, drawnPolygons, labelPlace, planned } from './plan/plan_geometry';

export interface Sentence {
  mark: string; // of its place on the plan; empty: it has none of its own
  say: string;
  todo: string;
}

// What is missing of a room, or of the whole home.
export interface CoverageGroup {
  heading: string;
  mark: string; // "2"; empty: it has no place
  sentences: Sentence[];
}

export interface CoverageMark {
  mark: string;
  at: Point;
  isRoom: boolean; // it stands for a whole room, below its name
}

export interface CoverageTold {
  groups: CoverageGroup[];
  marks: CoverageMark[];
}

export function tellCoverage(coverage: Coverage, home: Home, plan: Plan): CoverageTold {
  const told: CoverageTold = { groups: [], marks: [] };
  const add = (heading: string, missing: readonly Missing[], at: Point | null, mark: string): void => {
    if (at) {
      told.marks.push({ mark, at, isRoom: true });
    }
    let gaps = 0;
    const sentences = missing.map((one): Sentence => {
      if (!one.floor) {
        return { mark: '', ...wordsOf(one, coverage, home) };
      }
      gaps += 1;
      const own = `${mark}${String.fromCharCode(96 + gaps)}`; // 2a, 2b
      told.marks.push({ mark: own, at: one.floor.place, isRoom: false });
      return { mark: own, ...gapWords(one.floor, one.room, plan) };
    });
    told.groups.push({ heading, mark: at || gaps > 0 ? mark : '', sentences });
  };
  const ofHome = coverage.missing.filter(({ room }) => room === null);
  if (ofHome.length > 0) {
    add(text('coverage.whole_home'), ofHome, null, '');
  }
  const names = [...new Set(coverage.missing.flatMap(({ room }) => (room === null ? [] : [room])))];
  names.sort((a, b) => a.localeCompare(b));
  names.forEach((name, i) => {
    const place = labelPlace(drawnPolygons(plan.rooms.find((one) => one.name === name)?.polygons ?? [], plan));
    add(name, coverage.missing.filter(({ room }) => room === name), place ? planned(place.at, plan) : null, String(i + 1));
  });
  return told;
}

type Words = Omit<Sentence, 'mark'>;

function wordsOf(missing: Missing, coverage: Coverage, home: Home): Words {
  const { pictures, wanted } = missing;
  const walk = home.recordings.find(({ id }) => id === missing.walk)?.name ?? '';
  switch (missing.what) {
    case 'join':
      return { say: text('coverage.join', { walk }), todo: text('coverage.join_do') };
    case 'names':
      return { say: counted('coverage.names', pictures, { walk }), todo: text('coverage.names_do') };
    case 'pictures':
      return {
        say: pictures === 0 ? text('coverage.no_pictures') : counted('coverage.pictures', pictures),
        todo: text('coverage.pictures_do', { wanted: formatNumber(wanted ?? 0) }),
      };
    case 'more pictures':
      return { say: counted('coverage.more_pictures', pictures), todo: text('coverage.more_pictures_do', { wanted: formatNumber(wanted ?? 0) }) };
    case 'second walk':
      return oneWalkWords(missing, coverage, walk);
    default: // other light
      return { say: text('coverage.one_light'), todo: text('coverage.go_by_other') };
  }
}

function oneWalkWords(missing: Missing, coverage: Coverage, walk: string): Words {
  const time = coverage.rooms.find(({ room }) => room === missing.room)?.walks[0]?.time ?? null;
  const light = time === null ? null : lightAt(time);
  if (time === null || light === null) {
    return { say: text('coverage.one_walk', { walk }), todo: text('coverage.go_by_other') };
  }
  const when = formatTime(time);
  return light === 'day' ? { say: text('coverage.by_day', { walk, when }), todo: text('coverage.go_by_night') }
    : { say: text('coverage.by_night', { walk, when }), todo: text('coverage.go_by_day') };
}

// Between these hours it is light, or dark, on every day of the year wherever the sun rises daily; between them the
// hour alone does not tell.
export function lightAt(time_s: number): 'day' | 'night' | null {
  const hour = new Date(time_s * 1000).getHours();
  return hour >= 11 && hour < 14 ? 'day' : hour >= 23 || hour < 2 ? 'night' : null;
}

function gapWords(gap: FloorGap, room: string | null, plan: Plan): Words {
  const values = { place: placeWords(gap, room, plan), metres: formatNumber(gap.length_m, 1) };
  return { say: text(gap.unseen ? 'coverage.unseen' : 'coverage.afar', values), todo: text('coverage.floor_do') };
}

const kBesideDoor_m = 1.5; // as a thing is beside a place (FloorGap::beside)
const kSides = [
  ['bottom_left', 'bottom', 'bottom_right'], ['left', 'middle', 'right'], ['top_left', 'top', 'top_right'],
] as const;

// By what is there to touch; else by the side of the room that it is on.
export function placeWords({ beside, place }: Pick<FloorGap, 'beside' | 'place'>, room: string | null, plan: Plan): string {
  if (beside !== null) {
    return text('coverage.beside', { thing: beside });
  }
  const far = ([x, y]: Point): number => Math.hypot(x - place[0], y - place[1]);
  const [door] = plan.doors.filter(({ door, rooms, middle }) => door && rooms.some((one) => one === room) && far(middle) <= kBesideDoor_m)
    .sort((a, b) => far(a.middle) - far(b.middle));
  if (door) {
    return text('coverage.at_door', { room: door.rooms.find((one) => one !== room) ?? '' });
  }
  const corners = (plan.rooms.find(({ name }) => name === room)?.polygons.flat(2) ?? []).map((corner) => drawn(corner, plan));
  const shown = drawn(place, plan);
  const third = (axis: 0 | 1): 0 | 1 | 2 => {
    const all = corners.map((corner) => corner[axis]);
    const [low, high] = [Math.min(...all), Math.max(...all)];
    return corners.length === 0 ? 1 : Math.max(0, Math.min(2, Math.floor((3 * (shown[axis] - low)) / (high - low)))) as 0 | 1 | 2;
  };
  return text(`coverage.${kSides[third(1)][third(0)]}`);
}
