// The plan as plane geometry: what it spans, whose floor a point is, where a name has room. Metres, y up. Pure.
import type { Home, Plan, Point } from '../../shared/protocol';

export interface Span {
  left: number;
  bottom: number;
  width: number;
  height: number;
}

const kMargin_m = 0.4;

// A place of the plan as it is drawn: turned so that walls lie along the drawing's sides; and back.
export function drawn([x, y]: Point, { right_degrees = 0 }: Plan): Point {
  const [c, s] = [Math.cos((right_degrees * Math.PI) / 180), Math.sin((right_degrees * Math.PI) / 180)];
  return [c * x + s * y, c * y - s * x];
}
export function planned(point: Point, { right_degrees = 0 }: Plan): Point {
  return drawn(point, { rooms: [], doors: [], right_degrees: -right_degrees });
}
export function drawnPolygons(polygons: readonly Point[][][], plan: Plan): Point[][][] {
  return polygons.map((rings) => rings.map((ring) => ring.map((corner) => drawn(corner, plan))));
}

// All that is drawn, as it is drawn, with a margin; of nothing a square.
export function spanOf(plan: Plan, home: Home | null): Span {
  const points: Point[] = [
    ...plan.rooms.flatMap((room) => room.polygons.flat(2)),
    ...plan.doors.map((door) => door.middle),
    ...(home?.things ?? []).flatMap(({ position }): Point[] => (position ? [[position[0], position[1]]] : [])),
  ].map((point) => drawn(point, plan));
  if (points.length === 0) {
    return { left: 0, bottom: 0, width: 1, height: 1 };
  }
  const xs = points.map(([x]) => x);
  const ys = points.map(([, y]) => y);
  const [left, bottom] = [Math.min(...xs) - kMargin_m, Math.min(...ys) - kMargin_m];
  return { left, bottom, width: Math.max(...xs) + kMargin_m - left, height: Math.max(...ys) + kMargin_m - bottom };
}

// Whether a point lies inside rings: in the outer one and in no hole.
export function isInside(rings: readonly Point[][], [x, y]: Point): boolean {
  let inside = false;
  for (const ring of rings) {
    ring.forEach(([ax, ay], i) => {
      const [bx, by] = ring[(i + 1) % ring.length] as Point;
      if ((ay > y) !== (by > y) && x < ax + ((y - ay) / (by - ay)) * (bx - ax)) {
        inside = !inside;
      }
    });
  }
  return inside;
}

export function roomAt(plan: Plan, point: Point): string | null {
  return plan.rooms.find(({ polygons }) => polygons.some((rings) => isInside(rings, point)))?.name ?? null;
}

// The widest place of a room for its name: of the middles of stretches along some lines the one with the widest stretch.
export function labelPlace(polygons: readonly Point[][][]): { at: Point; width: number } | null {
  const kLines = 9;
  let best: { at: Point; width: number } | null = null;
  for (const rings of polygons) {
    const ys = (rings[0] ?? []).map(([, y]) => y);
    const [low, high] = [Math.min(...ys), Math.max(...ys)];
    for (let line = 1; line < kLines; line += 1) {
      const y = low + ((high - low) * line) / kLines;
      const crossings = rings.flatMap((ring) => ring.flatMap(([ax, ay], i) => {
        const [bx, by] = ring[(i + 1) % ring.length] as Point;
        return (ay > y) !== (by > y) ? [ax + ((y - ay) / (by - ay)) * (bx - ax)] : [];
      })).sort((a, b) => a - b);
      for (let i = 0; i + 1 < crossings.length; i += 2) {
        const [from, to] = [crossings[i] as number, crossings[i + 1] as number];
        // Lines in the middle are preferred where the room is about as wide there.
        const width = (to - from) * (1 - 0.2 * Math.abs((2 * line) / kLines - 1));
        if (best === null || width > best.width) {
          best = { at: [(from + to) / 2, y], width };
        }
      }
    }
  }
  return best;
}

// The line of the first two points, so directed that the third lies left of it, as the computer wants a room's.
export function lineWithLeft([from, to, side]: readonly Point[]): Point[] {
  if (!from || !to || !side) {
    return [];
  }
  const turn = (to[0] - from[0]) * (side[1] - from[1]) - (to[1] - from[1]) * (side[0] - from[0]);
  return turn > 0 ? [from, to] : [to, from];
}

export function pathOf(polygons: readonly Point[][][]): string {
  return polygons.flat().map((ring) =>
    `M${ring.map(([x, y]) => `${round(x)} ${round(-y)}`).join('L')}Z`).join('');
}

function round(value: number): number {
  return Math.round(value * 1000) / 1000;
}
