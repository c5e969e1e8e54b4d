// A way on the plan, in words. Pure.
import type { Plan, Point } from '../shared/protocol';
import { formatNumber, text } from '../shared/texts';
import { roomAt } from './plan/plan_geometry';

const kStep_m = 0.2; // a room that is crossed for less is crossed at its corner

// The rooms of a way, in the order in which it leads through them.
export function roomsOnWay(way: readonly Point[], plan: Plan): string[] {
  const rooms: string[] = [];
  way.forEach((to, i) => {
    const from = way[i - 1] ?? to;
    const steps = Math.max(1, Math.ceil(Math.hypot(to[0] - from[0], to[1] - from[1]) / kStep_m));
    for (let step = i === 0 ? steps : 1; step <= steps; step += 1) {
      const part = step / steps;
      const room = roomAt(plan, [from[0] + part * (to[0] - from[0]), from[1] + part * (to[1] - from[1])]);
      if (room !== null && room !== rooms[rooms.length - 1]) {
        rooms.push(room);
      }
    }
  });
  return rooms;
}

export function wayLength(way: readonly Point[]): number {
  return way.reduce((sum, [x, y], i) => {
    const [fromX, fromY] = way[i - 1] ?? [x, y];
    return sum + Math.hypot(x - fromX, y - fromY);
  }, 0);
}

export function wayWords(way: readonly Point[], plan: Plan): string {
  const rooms = roomsOnWay(way, plan).join(', ');
  const metres = formatNumber(wayLength(way), 1);
  return rooms === '' ? text('trial.way_unnamed', { metres }) : text('trial.way', { metres, rooms });
}

// From the first point to the second, counter-clockwise from x; of one point: up on the drawing.
export function headingOf([at, towards]: readonly Point[], { right_degrees = 0 }: Plan): number {
  return at && towards ? (Math.atan2(towards[1] - at[1], towards[0] - at[0]) * 180) / Math.PI : 90 + right_degrees;
}
