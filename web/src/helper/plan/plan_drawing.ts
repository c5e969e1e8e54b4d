// The plan as a drawing: rooms in colours with their names, doors, things. What it shows is told in words beside it.
import type { Home, Plan, Point } from '../../shared/protocol';
import { svg } from '../../shared/svg';
import { text } from '../../shared/texts';
import { drawn, drawnPolygons, labelPlace, pathOf, planned, spanOf, type Span } from './plan_geometry';

const kTones = 8; // of rooms' colours
const kLetter = 0.6; // about the width of a letter, of its size
// Of names, in pixels, however large the home is; the plan is about as wide as the window, up to a column's width.
const [kThingName_px, kRoomName_px, kMark_px] = [12, 14, 5];
const [kLeastWidth_px, kMostWidth_px, kBeside_px] = [220, 690, 80];
const [kMostHeight, kMostHeight_px] = [0.62, 640]; // of the window's

export interface PlanDrawing {
  element: SVGSVGElement;
  span: Span; // as it is drawn
  pixel_m: number; // about what a pixel of the window is
  overlay: SVGGElement; // for what is being drawn on it, in places of the plan, y down
  upright: string; // turns what has its place in the overlay by a `translate` as letters stand
  pointOf: (event: MouseEvent) => Point;
}

function round(value: number): number {
  return Math.round(value * 1000) / 1000;
}

export function toneOf(plan: Plan, room: string): number {
  return Math.max(0, plan.rooms.findIndex(({ name }) => name === room)) % kTones;
}

// `all`: the plan that it is a part of, by which rooms have their colours.
export function drawPlan(plan: Plan, home: Home | null, label: string, all: Plan = plan): PlanDrawing {
  const span = spanOf(plan, home);
  const element = svg('svg', {
    class: 'plan', role: 'img', 'aria-label': label,
    viewBox: `${span.left} ${-(span.bottom + span.height)} ${span.width} ${span.height}`,
  }) as SVGSVGElement;
  // As the style sheet lets it be high.
  const pixel_m = Math.max(
    span.width / Math.max(kLeastWidth_px, Math.min(window.innerWidth - kBeside_px, kMostWidth_px)),
    span.height / Math.min(kMostHeight * window.innerHeight, kMostHeight_px));
  const names: { at: Point; half: number; high: number }[] = [];
  const rooms = plan.rooms.map(({ name, polygons }) =>
    svg('path', { class: `floor tone-${toneOf(all, name)}`, d: pathOf(drawnPolygons(polygons, plan)), 'fill-rule': 'evenodd', 'data-room': name }));
  const doors = plan.doors.filter(({ door }) => door).map(({ middle, rooms: between }) => {
    const [x, y] = drawn(middle, plan);
    return svg('g', { class: 'door', transform: `translate(${round(x)} ${round(-y)})` },
      svg('title', {}, text('plan.door', { a: between[0], b: between[1] })),
      svg('circle', { r: 0.13 }), svg('path', { d: 'M-0.07 0H0.07' }));
  });
  const mark_m = kMark_px * pixel_m;
  const size = kThingName_px * pixel_m;
  const roomLabels = plan.rooms.flatMap(({ name, polygons }) => {
    const place = labelPlace(drawnPolygons(polygons, plan));
    if (!place) {
      return [];
    }
    const fitting = place.width / (kLetter * (name.length + 1));
    const size = Math.min(1.4 * kRoomName_px * pixel_m, Math.max(kRoomName_px * pixel_m, fitting));
    names.push({ at: place.at, half: (name.length * kLetter * size) / 2, high: size });
    return [svg('text', { class: 'room-name', x: place.at[0], y: -place.at[1], 'font-size': size }, name)];
  });
  const things = (home?.things ?? []).flatMap((thing) => {
    if (!thing.position) {
      return [];
    }
    const [x, y] = drawn([thing.position[0], thing.position[1]], plan);
    const d = round(1.5 * mark_m);
    const shape = thing.added ? svg('path', { d: `M0 ${-d}L${d} 0L0 ${d}L${-d} 0Z` }) : svg('circle', { r: mark_m });
    const parts = [svg('title', {}, thing.name), shape];
    // A name that would cover another is left out; the title has it, and the list.
    const half = (thing.name.length * kLetter * size) / 2;
    const below = mark_m + size;
    const at: Point = [x, y - below];
    const covers = names.some((other) =>
      Math.abs(other.at[0] - at[0]) < other.half + half && Math.abs(other.at[1] - at[1]) < (other.high + size) / 2);
    const leaves = x - half < span.left || x + half > span.left + span.width;
    if (!covers && !leaves) {
      names.push({ at, half, high: size });
      parts.push(svg('text', { class: 'thing-name', y: round(below), 'font-size': round(size) }, thing.name));
    }
    return [svg('g', { class: `mark${thing.added ? ' added' : ''}`, transform: `translate(${round(x)} ${round(-y)})`, 'data-thing': thing.id }, ...parts)];
  });
  const { right_degrees = 0 } = plan;
  const overlay = svg('g', { class: 'drawing', transform: `rotate(${right_degrees})` }) as SVGGElement;
  element.append(...rooms, ...doors, ...roomLabels, ...things, overlay);
  return {
    element, span, pixel_m, overlay, upright: `rotate(${-right_degrees})`,
    pointOf: (event) => {
      const matrix = element.getScreenCTM();
      const point = new DOMPoint(event.clientX, event.clientY).matrixTransform(matrix?.inverse());
      return planned([point.x, -point.y], plan);
    },
  };
}
