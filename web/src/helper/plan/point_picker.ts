// Points on the plan, by tapping or by keyboard: arrow keys move a cross, Enter sets a point, Backspace takes the last
// away. What the cross is over is said.
import { h } from '../../shared/dom';
import type { Home, Plan, Point } from '../../shared/protocol';
import { svg } from '../../shared/svg';
import { formatNumber, text } from '../../shared/texts';
import { drawPlan } from './plan_drawing';
import { drawn, planned, roomAt } from './plan_geometry';

const kStep_m = 0.1;
const kLongStep_m = 0.5; // with Shift

export interface PointPicker {
  element: HTMLElement;
  points: () => Point[];
}

export interface PickerOptions {
  label: string;
  most: number; // points; a further one takes the place of the last
  shape?: 'outline' | 'line'; // the last point leads back to the first; the first two are of a line that goes on
  start?: Point | null; // where the cross is to begin with
}

export function pointPicker(plan: Plan, home: Home, options: PickerOptions): PointPicker {
  const drawing = drawPlan(plan, home, '');
  drawing.element.setAttribute('aria-hidden', 'true');
  drawing.element.removeAttribute('role');
  const { span } = drawing;
  const points: Point[] = [];
  let cross: Point = options.start ?? planned([span.left + span.width / 2, span.bottom + span.height / 2], plan);
  const said = h('p', { class: 'hint', role: 'status' });
  const field = h('div', {
    class: 'plan-stage picker', tabindex: 0, role: 'application', 'aria-label': `${options.label} ${text('picker.keys')}`,
  }, drawing.element);

  const place = (point: Point): string => {
    const [x, y] = drawn(point, plan);
    return text('picker.place', {
      room: roomAt(plan, point) ?? text('picker.no_room'),
      x: formatNumber(x - span.left, 1), y: formatNumber(y - span.bottom, 1),
    });
  };
  const show = (): void => {
    drawing.overlay.textContent = '';
    const shape = shapeOf(points, options.shape, Math.hypot(span.width, span.height));
    if (shape.length > 1) {
      drawing.overlay.append(svg('polyline', { points: shape.map(([x, y]) => `${x},${-y}`).join(' ') }));
    }
    const upright = ([x, y]: Point): string => `translate(${x} ${-y}) ${drawing.upright}`;
    points.forEach((point, i) => drawing.overlay.append(svg('g', { transform: upright(point) },
      svg('circle', { r: 0.11 }), svg('text', { y: -0.17, 'font-size': 0.2 }, String(i + 1)))));
    drawing.overlay.append(svg('path', { class: 'cross', transform: upright(cross), d: 'M-0.25 0h0.5M0 -0.25v0.5' }));
  };
  const set = (point: Point): void => {
    cross = point;
    if (points.length === options.most) {
      points.pop();
    }
    points.push(point);
    said.textContent = text('picker.set', { number: points.length, place: place(point) });
    show();
  };
  const kMoves: Record<string, Point> = { ArrowLeft: [-1, 0], ArrowRight: [1, 0], ArrowUp: [0, 1], ArrowDown: [0, -1] };
  field.addEventListener('keydown', (event) => {
    const move = kMoves[event.key];
    if (move) {
      const step = event.shiftKey ? kLongStep_m : kStep_m;
      const [x, y] = drawn(cross, plan);
      cross = planned([
        Math.min(span.left + span.width, Math.max(span.left, x + step * move[0])),
        Math.min(span.bottom + span.height, Math.max(span.bottom, y + step * move[1])),
      ], plan);
      said.textContent = place(cross);
    } else if (event.key === 'Enter' || event.key === ' ') {
      set(cross);
    } else if (event.key === 'Backspace') {
      points.pop();
      said.textContent = text('picker.taken', { count: points.length });
    } else {
      return;
    }
    event.preventDefault();
    show();
  });
  drawing.element.addEventListener('click', (event) => set(drawing.pointOf(event)));
  show();
  return {
    element: h('div', { class: 'field' },
      h('p', { class: 'picker-label' }, options.label), h('p', { class: 'hint' }, text('picker.keys')), field, said),
    points: () => [...points],
  };
}

function shapeOf(points: readonly Point[], shape: PickerOptions['shape'], far_m: number): Point[] {
  const [first, second] = points;
  if (shape === 'outline' && first && points.length > 2) {
    return [...points, first];
  }
  if (shape !== 'line' || !first || !second) {
    return [...points];
  }
  const length = Math.hypot(second[0] - first[0], second[1] - first[1]) || 1;
  const [x, y] = [((second[0] - first[0]) / length) * far_m, ((second[1] - first[1]) / length) * far_m];
  return [[first[0] - x, first[1] - y], [second[0] + x, second[1] + y]];
}
