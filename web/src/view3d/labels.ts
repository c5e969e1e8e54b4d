// Names over the picture: of rooms, things, and devices. The same names are in the text beside it, so screen readers
// are not told of these.
import { Vector3, type Camera } from 'three';

import { h } from '../shared/dom';
import type { DeviceSeen, Home, Vector } from '../shared/protocol';
import { levelOf } from '../shared/storeys';

interface Label {
  element: HTMLElement;
  at: Vector3;
}

export class Labels {
  readonly element = h('div', { class: 'labels', 'aria-hidden': 'true' });
  private ofHome: Label[] = [];
  private ofDevices: Label[] = [];

  setHome(home: Home): void {
    const inSpace = (place: Vector): Vector => levelOf(home.storeys ?? [], place);
    this.ofHome = this.replace(this.ofHome, [
      ...home.rooms.flatMap(({ name, middle }) => (middle ? [make('room-label', name, inSpace([...middle, 0.02]))] : [])),
      ...home.things.flatMap(({ name, position, size }) =>
        (position ? [make('thing-label', name, inSpace([position[0], position[1], position[2] + size[2] / 2 + 0.08]))] : [])),
    ]);
  }

  setDevices(devices: readonly DeviceSeen[]): void {
    this.ofDevices = this.replace(this.ofDevices, devices.flatMap(({ name, seen }) =>
      (seen?.position ? [make('device-label', name, [seen.position.x, seen.position.y, seen.position.z + 0.3])] : [])));
  }

  place(camera: Camera, width: number, height: number): void {
    const taken: { x: number; y: number; half: number }[] = [];
    // Devices and rooms before things: a thing's name that would cover another name is left out.
    for (const { element, at } of [...this.ofDevices, ...this.ofHome]) {
      const projected = at.clone().project(camera);
      const [x, y] = [((projected.x + 1) / 2) * width, ((1 - projected.y) / 2) * height];
      const half = 4 * (element.textContent ?? '').length + 8;
      const inside = projected.z < 1 && x > half && x < width - half && y > 10 && y < height - 10;
      const covers = taken.some((other) => Math.abs(other.x - x) < other.half + half && Math.abs(other.y - y) < 22);
      element.hidden = !inside || (covers && element.classList.contains('thing-label'));
      if (!element.hidden) {
        taken.push({ x, y, half });
        element.style.transform = `translate(-50%, -50%) translate(${x.toFixed(1)}px, ${y.toFixed(1)}px)`;
      }
    }
  }

  private replace(old: readonly Label[], labels: Label[]): Label[] {
    old.forEach(({ element }) => element.remove());
    this.element.append(...labels.map(({ element }) => element));
    return labels;
  }
}

function make(kind: string, words: string, at: readonly number[]): Label {
  return { element: h('span', { class: kind }, words), at: new Vector3(...at) };
}
