// The home in three dimensions. Loaded only when it is looked at, since three.js is large; drawn only when something
// changed.
import { BufferAttribute, BufferGeometry, Group, PerspectiveCamera, Points, PointsMaterial, Scene, WebGLRenderer } from 'three';

import type { DeviceSeen, Home, Keyframe } from '../shared/protocol';
import { boundsOf, cloudFrom } from './cloud';
import { drag } from './drag';
import { Labels } from './labels';
import { devicesInSpace } from '../shared/storeys';
import { deviceMarks, homeMarks, keyframeMarks, keyframeUnder, schemeColours } from './marks';
import { eyeOf, kHighest, moved, turned, zoomed, type Orbit } from './orbit';

export interface View3d {
  setHome: (home: Home, keyframes: readonly Keyframe[]) => void;
  setCloud: (bytes: ArrayBuffer) => void; // the coarse one, which the view is turned to
  refineCloud: (bytes: ArrayBuffer) => void; // the fine one in its place
  setSeen: (seen: readonly DeviceSeen[]) => void;
  turn: (degrees: number) => void;
  zoom: (factor: number) => void;
  fromAbove: () => void;
}

export interface ViewEvents {
  keyframeChosen: (id: number) => void;
  moved: () => void; // by the person
}

// As three.js takes it: about twice what is drawn. A point covers the way to the next.
const kPointSize = { coarse: 0.1, fine: 0.065 };

// Throws where the browser cannot draw in three dimensions.
export function makeView(stage: HTMLElement, events: ViewEvents): View3d {
  const renderer = new WebGLRenderer({ antialias: true, alpha: true });
  renderer.setPixelRatio(Math.min(2, window.devicePixelRatio));
  const canvas = renderer.domElement;
  const labels = new Labels();
  stage.append(canvas, labels.element);

  const scene = new Scene();
  const camera = new PerspectiveCamera(50, 1, 0.05, 500);
  camera.up.set(0, 0, 1);
  const cloud = new Group();
  const home = new Group();
  const walk = new Group();
  const devices = new Group();
  scene.add(cloud, home, walk, devices);

  let orbit: Orbit = { target: [0, 0, 0], distance: 10, azimuth: -Math.PI / 2, height: 0.9 };
  let limits = { least: 0.5, most: 50 };
  let waiting = false;
  const draw = (): void => {
    if (!waiting && stage.isConnected) { // shown again it is drawn, since its size changes then
      waiting = true;
      window.requestAnimationFrame(() => {
        waiting = false;
        camera.position.set(...eyeOf(orbit));
        camera.lookAt(...orbit.target);
        renderer.render(scene, camera);
        labels.place(camera, canvas.clientWidth, canvas.clientHeight);
      });
    }
  };
  const look = (next: Orbit): void => {
    orbit = next;
    draw();
  };
  const move = (next: Orbit): void => {
    look(next);
    events.moved();
  };
  const frame = (positions: ArrayLike<number>): void => {
    const { middle, radius } = boundsOf(positions);
    limits = { least: radius / 20, most: radius * 8 };
    look({ ...orbit, target: middle, distance: (radius * 1.8) / Math.min(1, camera.aspect) });
  };

  new ResizeObserver(() => {
    const { clientWidth, clientHeight } = stage;
    if (clientWidth > 0 && clientHeight > 0) {
      camera.aspect = clientWidth / clientHeight;
      camera.updateProjectionMatrix();
      renderer.setSize(clientWidth, clientHeight);
      draw();
    }
  }).observe(stage);
  drag(canvas, {
    turn: (right, up) => move(turned(orbit, -right * 0.008, up * 0.008)),
    move: (right, up) => move(moved(orbit, (-right * orbit.distance) / 600, (up * orbit.distance) / 600)),
    zoom: (factor) => move(zoomed(orbit, factor, limits)),
    tap: (x, y) => {
      const id = keyframeUnder(walk, camera, x, y);
      if (id !== null) {
        events.keyframeChosen(id);
      }
    },
  });

  // Gives where the points are.
  const showCloud = (bytes: ArrayBuffer, size: number): Float32Array => {
    const { positions, colours } = cloudFrom(bytes);
    const geometry = new BufferGeometry();
    geometry.setAttribute('position', new BufferAttribute(positions, 3));
    geometry.setAttribute('color', new BufferAttribute(colours, 3, true));
    refill(cloud, [new Points(geometry, new PointsMaterial({ size, vertexColors: true }))]);
    draw();
    return positions;
  };

  // What was marked last, in the colours of the light or dark scheme; a phone changes it by itself in the evening.
  let markHome = (): void => undefined;
  let markSeen = (): void => undefined;
  window.matchMedia('(prefers-color-scheme: dark)').addEventListener('change', () => {
    markHome();
    markSeen();
    draw();
  });

  let known: Home | null = null;
  return {
    setHome: (now, keyframes) => {
      known = now;
      markHome = () => {
        const colours = schemeColours();
        refill(home, homeMarks(now, colours));
        refill(walk, keyframeMarks(keyframes, now.recordings.map(({ id }) => id)));
      };
      markHome();
      labels.setHome(now);
      if (cloud.children.length === 0) {
        frame(keyframes.flatMap(({ position }) => position));
      }
      draw();
    },
    setCloud: (bytes) => frame(showCloud(bytes, kPointSize.coarse)),
    refineCloud: (bytes) => void showCloud(bytes, kPointSize.fine),
    setSeen: (seen) => {
      const placed = devicesInSpace(known, seen.filter((one) => one.online && one.seen?.position));
      if (placed.length === 0 && devices.children.length === 0) {
        return; // a phone that is nowhere on the map tells of itself four times a second
      }
      markSeen = () => refill(devices, deviceMarks(placed, schemeColours()));
      markSeen();
      labels.setDevices(placed);
      draw();
    },
    turn: (degrees) => move(turned(orbit, (degrees * Math.PI) / 180)),
    zoom: (factor) => move(zoomed(orbit, factor, limits)),
    fromAbove: () => move({ ...orbit, azimuth: -Math.PI / 2, height: kHighest }),
  };
}

// Gives the memory of what was there back.
function refill(group: Group, children: readonly Parameters<Group['add']>[0][]): void {
  for (const child of [...group.children]) {
    child.traverse((one) => {
      if ('geometry' in one && one.geometry instanceof BufferGeometry) {
        one.geometry.dispose();
      }
    });
    group.remove(child);
  }
  children.forEach((child) => group.add(child));
}
