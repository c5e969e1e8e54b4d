// From what WebXR tells of a view to what the computer's protocol has: intrinsics, pose, depth. Pure.
import type { FramePose, Intrinsics } from '../../shared/protocol';
import type { XrDepthInformation, XrRigidTransform } from './webxr';

// Of a picture of that size that shows the whole view. A point (x, y, z) of the view lies at x_ndc = (p0 x + p8 z) / -z of
// the projection matrix p, and a pixel's centre at whole numbers.
export function intrinsicsOf(p: ArrayLike<number>, width: number, height: number): Intrinsics {
  const at = (i: number): number => p[i] ?? 0;
  return {
    width, height,
    fx: (width / 2) * at(0), fy: (height / 2) * at(5),
    cx: (width / 2) * (1 - at(8)) - 0.5, cy: (height / 2) * (1 + at(9)) - 0.5,
  };
}

// WebXR's cameras look along -z with y up, the protocol's along z with y down: half a turn about x between them. The
// reference space is level, y up.
export function poseOf({ position, orientation: q }: XrRigidTransform): FramePose {
  return {
    source: 'webxr',
    position: [position.x, position.y, position.z],
    rotation_xyzw: [q.w, q.z, -q.y, -q.x], // q times (1, 0, 0, 0)
    up: [0, 1, 0],
    covariance: null,
  };
}

export interface DepthGrid {
  width: number;
  height: number;
  millimetres: Uint16Array; // row by row from the top left; 0: not measured
}

const kMost_mm = 65_535;

// The depth buffer lies as the sensor does, often on its side: this is the grid that lies as the view does.
export function depthOfView(depth: XrDepthInformation, format: string | undefined): DepthGrid {
  const m = depth.normDepthBufferFromNormView.matrix;
  const at = (i: number): number => m[i] ?? 0;
  const values = format === 'float32' ? new Float32Array(depth.data) : new Uint16Array(depth.data);
  const isOnItsSide = Math.abs(at(0)) < Math.abs(at(1));
  const [width, height] = isOnItsSide ? [depth.height, depth.width] : [depth.width, depth.height];
  const millimetres = new Uint16Array(width * height);
  for (let y = 0; y < height; y += 1) {
    for (let x = 0; x < width; x += 1) {
      const [u, v] = [(x + 0.5) / width, (y + 0.5) / height];
      const column = Math.floor((at(0) * u + at(4) * v + at(12)) * depth.width);
      const row = Math.floor((at(1) * u + at(5) * v + at(13)) * depth.height);
      if (column < 0 || row < 0 || column >= depth.width || row >= depth.height) {
        continue; // the sensor does not see as far to the side
      }
      const mm = Math.round((values[row * depth.width + column] ?? 0) * depth.rawValueToMeters * 1000);
      millimetres[y * width + x] = mm > 0 && mm <= kMost_mm ? mm : 0;
    }
  }
  return { width, height, millimetres };
}

export function measured(grid: DepthGrid): boolean {
  return grid.millimetres.some((mm) => mm > 0);
}
