// What is drawn beside the cloud: things as boxes, doors, the walk with its key-frames, devices.
import {
  BoxGeometry, BufferGeometry, ConeGeometry, DoubleSide, EdgesGeometry, InstancedMesh, Line, LineBasicMaterial, LineSegments, Matrix4,
  Mesh, MeshBasicMaterial, Quaternion, Raycaster, RingGeometry, Vector2, Vector3, type Camera, type Group, type Object3D,
} from 'three';

import type { DeviceSeen, Doorway, Home, Keyframe, Storey, Thing } from '../shared/protocol';
import { levelOf } from '../shared/storeys';
import { kWalkColours } from './walk_colours';

export interface Colours {
  accent: string;
  ink: string;
}

const kKeyframe_m = 0.09;
const kTapNear_m = 0.25;

// As the page's style says, light or dark.
export function schemeColours(): Colours {
  const style = getComputedStyle(document.documentElement);
  return { accent: style.getPropertyValue('--accent').trim(), ink: style.getPropertyValue('--ink').trim() };
}

export function homeMarks(home: Home, { accent, ink }: Colours): Object3D[] {
  return [
    ...home.things.flatMap((thing) => thingBox(thing, ink, home.storeys ?? [])),
    ...home.doorways.flatMap((doorway) => doorMark(doorway, accent, home.storeys ?? [])),
  ];
}

function thingBox({ position, size }: Thing, colour: string, storeys: readonly Storey[]): Object3D[] {
  if (!position) {
    return [];
  }
  const box = new BoxGeometry(...size);
  const edges = new LineSegments(new EdgesGeometry(box), new LineBasicMaterial({ color: colour }));
  box.dispose();
  edges.position.set(...levelOf(storeys, position));
  return [edges];
}

function doorMark({ door, middle }: Doorway, colour: string, storeys: readonly Storey[]): Object3D[] {
  if (!middle || !door) {
    return [];
  }
  const ring = new Mesh(new RingGeometry(0.22, 0.3, 32), new MeshBasicMaterial({ color: colour, side: DoubleSide }));
  ring.position.set(...levelOf(storeys, [middle[0], middle[1], 0.03]));
  return [ring];
}

// Of each walk a line through it and a small pyramid a key-frame, its point at the camera, in the walk's colour. `walks`:
// their numbers, in order.
export function keyframeMarks(keyframes: readonly Keyframe[], walks: readonly number[]): Object3D[] {
  return walks.flatMap((walk, i) => {
    const own = keyframes.filter(({ recording }) => recording === walk);
    return own.length === 0 ? [] : walkMarks(own, kWalkColours[i % kWalkColours.length] as string);
  });
}

function walkMarks(keyframes: readonly Keyframe[], color: string): Object3D[] {
  const line = new Line(
    new BufferGeometry().setFromPoints(keyframes.map(({ position }) => new Vector3(...position))),
    new LineBasicMaterial({ color }),
  );
  const cone = new ConeGeometry(kKeyframe_m, 1.5 * kKeyframe_m, 4);
  cone.rotateX(-Math.PI / 2); // a cone's point is +y; a camera looks along +z, so the point goes to -z
  const cones = new InstancedMesh(cone, new MeshBasicMaterial({ color }), keyframes.length);
  const size = new Vector3(1, 1, 1);
  keyframes.forEach(({ position, rotation_xyzw }, i) => {
    cones.setMatrixAt(i, new Matrix4().compose(new Vector3(...position), new Quaternion(...rotation_xyzw).normalize(), size));
  });
  cones.userData['keyframes'] = keyframes.map(({ id, position }) => ({ id, position }));
  return [line, cones];
}

// The key-frame that was tapped: the one nearest to the line of sight, of two as near the one nearer to the eye. x, y: -1 to 1, y up.
export function keyframeUnder(walk: Group, camera: Camera, x: number, y: number): number | null {
  const ray = new Raycaster();
  ray.setFromCamera(new Vector2(x, y), camera);
  const marks = walk.children.flatMap((child) => (child.userData['keyframes'] ?? []) as Pick<Keyframe, 'id' | 'position'>[]);
  const near = marks
    .map(({ id, position }) => ({ id, at: new Vector3(...position) }))
    .map(({ id, at }) => ({ id, off: ray.ray.distanceToPoint(at), away: ray.ray.origin.distanceTo(at) }))
    .filter(({ off }) => off < kTapNear_m)
    .sort((a, b) => a.off - b.off || a.away - b.away);
  return near[0]?.id ?? null;
}

// An arrow where it is and as it looks.
export function deviceMarks(devices: readonly DeviceSeen[], { accent }: Colours): Object3D[] {
  return devices.flatMap(({ seen }) => {
    const position = seen?.position;
    if (!position) {
      return [];
    }
    const arrow = new ConeGeometry(0.14, 0.5, 16);
    arrow.rotateZ(-Math.PI / 2); // its point to +x
    const mark = new Mesh(arrow, new MeshBasicMaterial({ color: accent }));
    mark.position.set(position.x, position.y, position.z);
    mark.rotation.z = (position.heading_degrees * Math.PI) / 180;
    return [mark];
  });
}
