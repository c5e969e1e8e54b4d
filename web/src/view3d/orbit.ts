// Where the eye is: on a ball about a point that it looks at. Pure.
export interface Orbit {
  target: [number, number, number];
  distance: number;
  azimuth: number; // radians, counter-clockwise about z
  height: number; // radians above the level
}

export const kHighest = Math.PI / 2 - 0.001; // straight above, all but
const kLowest = -0.2;

export function eyeOf({ target, distance, azimuth, height }: Orbit): [number, number, number] {
  const level = distance * Math.cos(height);
  return [
    target[0] + level * Math.cos(azimuth), target[1] + level * Math.sin(azimuth), target[2] + distance * Math.sin(height),
  ];
}

export function turned(orbit: Orbit, azimuth: number, height = 0): Orbit {
  return {
    ...orbit,
    azimuth: orbit.azimuth + azimuth,
    height: Math.max(kLowest, Math.min(kHighest, orbit.height + height)),
  };
}

export function zoomed(orbit: Orbit, factor: number, limits: { least: number; most: number }): Orbit {
  return { ...orbit, distance: Math.max(limits.least, Math.min(limits.most, orbit.distance * factor)) };
}

// Along the picture's own axes, parallel to the floor.
export function moved(orbit: Orbit, right: number, away: number): Orbit {
  const [c, s] = [Math.cos(orbit.azimuth), Math.sin(orbit.azimuth)];
  const [x, y, z] = orbit.target;
  return { ...orbit, target: [x - right * s - away * c, y + right * c - away * s, z] };
}
