// Homes of several storeys: places of rooms, things and devices lie on the plan, which draws storeys side by side; the
// view in space has them above one another. Pure.
import type { DeviceSeen, Home, Plan, Storey, Vector } from './protocol';

export function storeyAt(storeys: readonly Storey[], x: number): number {
  return storeys.reduce((here, { from_x }, i) => (from_x === null || x >= from_x ? i : here), 0);
}

// A place of the plan where it is in space.
export function levelOf(storeys: readonly Storey[], [x, y, z]: Vector): Vector {
  const storey = storeys[storeyAt(storeys, x)];
  return storey ? [x - storey.plan_from_level[0], y - storey.plan_from_level[1], z + storey.floor_m] : [x, y, z];
}

export function devicesInSpace(home: Home | null, devices: readonly DeviceSeen[]): DeviceSeen[] {
  return devices.map((one) => {
    const position = one.seen?.position;
    if (!one.seen || !position) {
      return one;
    }
    const [x, y, z] = levelOf(home?.storeys ?? [], [position.x, position.y, position.z]);
    return { ...one, seen: { ...one.seen, position: { ...position, x, y, z } } };
  });
}

// What of the home one storey holds; of a home of one storey all.
export function onStorey(plan: Plan, home: Home, storey: number): { plan: Plan; home: Home } {
  const storeys = home.storeys ?? [];
  if (storeys.length < 2) {
    return { plan, home };
  }
  const isHere = (x: number | undefined): boolean => x !== undefined && storeyAt(storeys, x) === storey;
  return {
    plan: {
      rooms: plan.rooms.filter(({ polygons }) => isHere(polygons[0]?.[0]?.[0]?.[0])),
      doors: plan.doors.filter(({ middle }) => isHere(middle[0])),
    },
    home: { ...home, things: home.things.filter(({ position }) => isHere(position?.[0])) },
  };
}
