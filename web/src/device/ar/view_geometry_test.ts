import assert from 'node:assert/strict';
import { test } from 'node:test';

import { depthOfView, intrinsicsOf, measured, poseOf } from './view_geometry';

// Rotates a vector by a quaternion.
function rotated([x, y, z, w]: readonly number[], v: readonly number[]): number[] {
  const [qx = 0, qy = 0, qz = 0, qw = 1] = [x, y, z, w];
  const [a = 0, b = 0, c = 0] = v;
  const t = [2 * (qy * c - qz * b), 2 * (qz * a - qx * c), 2 * (qx * b - qy * a)];
  const [ta = 0, tb = 0, tc = 0] = t;
  return [a + qw * ta + qy * tc - qz * tb, b + qw * tb + qz * ta - qx * tc, c + qw * tc + qx * tb - qy * ta];
}

test('intrinsics follow from the projection matrix: a point falls on the same pixel either way', () => {
  const p = new Float32Array(16);
  [p[0], p[5], p[8], p[9], p[10], p[11], p[14]] = [2, 1.2, 0.1, -0.05, -1, -1, -0.2];
  const { fx, fy, cx, cy } = intrinsicsOf(p, 300, 640);
  const [x, y, z] = [0.3, 0.4, -2]; // of the view: right, up, and before it
  const ndc = [((p[0] ?? 0) * x + (p[8] ?? 0) * z) / -z, ((p[5] ?? 0) * y + (p[9] ?? 0) * z) / -z];
  const pixel = [((ndc[0] ?? 0) + 1) * 150 - 0.5, (1 - (ndc[1] ?? 0)) * 320 - 0.5];
  assert.ok(Math.abs(fx * (x / -z) + cx - (pixel[0] ?? 0)) < 1e-4);
  assert.ok(Math.abs(fy * (-y / -z) + cy - (pixel[1] ?? 0)) < 1e-4);
});

test('a pose takes the camera’s forward and down to where WebXR’s back and up are turned round', () => {
  const orientation = { x: 0.5, y: 0.5, z: -0.1, w: Math.sqrt(1 - 0.51) };
  const pose = poseOf({ position: { x: 1, y: 2, z: 3 }, orientation, matrix: new Float32Array(16) });
  const q = [orientation.x, orientation.y, orientation.z, orientation.w];
  const near = (a: number[], b: number[]): void => a.forEach((value, i) => assert.ok(Math.abs(value - (b[i] ?? 0)) < 1e-9));
  near(rotated(pose.rotation_xyzw, [0, 0, 1]), rotated(q, [0, 0, -1]));
  near(rotated(pose.rotation_xyzw, [0, 1, 0]), rotated(q, [0, -1, 0]));
  near(rotated(pose.rotation_xyzw, [1, 0, 0]), rotated(q, [1, 0, 0]));
  assert.deepEqual(pose.position, [1, 2, 3]);
  assert.deepEqual(pose.up, [0, 1, 0], 'the reference space is level');
});

// The buffer lies on its side: its columns run down the view, its rows from right to left.
test('a depth buffer that lies on its side is laid as the view is', () => {
  const matrix = new Float32Array([0, -1, 0, 0, 1, 0, 0, 0, 0, 0, 1, 0, 0, 1, 0, 1]); // (u, v) to (v, 1 - u)
  const raw = new Uint16Array([10, 20, 30, 40, 50, 60]); // 3 wide, 2 high
  const grid = depthOfView(
    { width: 3, height: 2, data: raw.buffer, rawValueToMeters: 0.1, normDepthBufferFromNormView: { matrix } }, 'luminance-alpha');
  assert.deepEqual([grid.width, grid.height], [2, 3]);
  assert.deepEqual([...grid.millimetres], [4000, 1000, 5000, 2000, 6000, 3000]);
});

test('what the sensor does not see, and what no 16 bits hold, is not measured', () => {
  const matrix = new Float32Array([1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0.5, 0, 0, 1]); // half a picture to the side
  const data = new Float32Array([1, 70, 2, 3]).buffer;
  const grid = depthOfView({ width: 4, height: 1, data, rawValueToMeters: 1, normDepthBufferFromNormView: { matrix } }, 'float32');
  assert.deepEqual([...grid.millimetres], [2000, 3000, 0, 0]);
  const far = depthOfView({ width: 1, height: 1, data: new Float32Array([70]).buffer, rawValueToMeters: 1, normDepthBufferFromNormView: { matrix: new Float32Array([1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1]) } }, 'float32');
  assert.equal(measured(far), false);
  assert.equal(measured(grid), true);
});
