// The cloud as the computer sends it: 16 bytes a point, x, y, z (float32, little endian), r, g, b, 255. Pure.
export const kPointBytes = 16;

export interface Cloud {
  count: number;
  positions: Float32Array; // x, y, z
  colours: Uint8Array; // r, g, b
}

export function cloudFrom(bytes: ArrayBuffer): Cloud {
  if (bytes.byteLength % kPointBytes !== 0) {
    throw new Error(`a cloud of ${bytes.byteLength} bytes, which is no multiple of ${kPointBytes}`);
  }
  const count = bytes.byteLength / kPointBytes;
  const view = new DataView(bytes);
  const positions = new Float32Array(3 * count);
  const colours = new Uint8Array(3 * count);
  for (let i = 0; i < count; i += 1) {
    for (let axis = 0; axis < 3; axis += 1) {
      positions[3 * i + axis] = view.getFloat32(kPointBytes * i + 4 * axis, true);
      colours[3 * i + axis] = view.getUint8(kPointBytes * i + 12 + axis);
    }
  }
  return { count, positions, colours };
}

export interface Bounds {
  middle: [number, number, number];
  radius: number; // of a ball that holds nearly all
}

// Of points (x, y, z in a row); the outermost hundredth does not count, since depth cameras see through windows.
export function boundsOf(positions: ArrayLike<number>): Bounds {
  const count = Math.floor(positions.length / 3);
  if (count === 0) {
    return { middle: [0, 0, 0], radius: 3 };
  }
  const ranges = [0, 1, 2].map((axis) => {
    const values = Float32Array.from({ length: count }, (_, i) => positions[3 * i + axis] ?? 0).sort();
    const at = (part: number): number => values[Math.round(part * (count - 1))] ?? 0;
    return [at(0.01), at(0.99)] as const;
  });
  const middle = ranges.map(([low, high]) => (low + high) / 2) as [number, number, number];
  const radius = Math.hypot(...ranges.map(([low, high]) => (high - low) / 2));
  return { middle, radius: Math.max(radius, 0.5) };
}
