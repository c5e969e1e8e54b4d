// A picture with the boxes of its things. A drag on the picture draws the chosen thing's box; its corners and sides are dragged to correct it;
// a click on another thing's box chooses that thing.
import { svg } from '../shared/svg';
import { boxBetween, moved, viewOf, withSide, type Border, type Box, type Picture, type Thing } from './labels';

export interface PictureView {
  element: SVGSVGElement;
  show: (picture: Picture, things: readonly Thing[], chosen: number | null) => void;
}

export interface PictureEvents {
  drawn: (box: Box) => void; // of the chosen thing
  chosen: (id: number) => void;
}

interface Drag {
  from: readonly [number, number];
  before: Box | null; // of what is moved; null: a new one is drawn
  sides: readonly Border[]; // that move; none: all of it does
  now: Box | null;
  under: number | null; // the thing whose box it began on
}

export function pictureView(events: PictureEvents): PictureView {
  const image = svg('image', {});
  const boxes = svg('g', {});
  const draft = svg('rect', { class: 'draft', visibility: 'hidden' });
  const element = svg('svg', { class: 'picture', role: 'img' }, image, boxes, draft) as SVGSVGElement;
  let picture: Picture | null = null;
  let box: Box | null = null; // of the chosen thing
  let drag: Drag | null = null;

  const point = (event: PointerEvent): readonly [number, number] => {
    const shown = element.getBoundingClientRect();
    const { width = 1, height = 1 } = picture ?? {};
    return [((event.clientX - shown.left) * width) / shown.width, ((event.clientY - shown.top) * height) / shown.height];
  };
  const follow = (event: PointerEvent): void => {
    if (!drag || !picture) {
      return;
    }
    const [x, y] = point(event);
    const [dx, dy] = [x - drag.from[0], y - drag.from[1]];
    const { before, sides } = drag;
    const shown = picture;
    if (before === null) {
      drag.now = boxBetween(drag.from[0], drag.from[1], x, y);
    } else if (sides.length === 0) {
      drag.now = moved(before, dx, dy, shown);
    } else {
      drag.now = sides.reduce((last, side) => withSide(last, side, side === 'left' || side === 'right' ? dx : dy, shown), before);
    }
    place(draft, drag.now);
  };
  element.addEventListener('pointerdown', (event) => {
    if (event.button !== 0 || !picture) {
      return;
    }
    event.preventDefault();
    element.setPointerCapture(event.pointerId);
    const { sides, thing } = (event.target as SVGElement).dataset;
    drag = {
      from: point(event), before: sides === undefined ? null : box, now: null,
      sides: (sides ?? '').split(' ').filter((side) => side !== '') as Border[],
      under: thing === undefined ? null : Number(thing),
    };
  });
  element.addEventListener('pointermove', follow);
  element.addEventListener('pointerup', (event) => {
    follow(event);
    const { now = null, under = null } = drag ?? {};
    drag = null;
    place(draft, null);
    if (now) {
      events.drawn(now);
    } else if (under !== null) {
      events.chosen(under);
    }
  });
  element.addEventListener('pointercancel', () => {
    drag = null;
    place(draft, null);
  });

  return {
    element,
    show: (next, things, chosen) => {
      picture = next;
      element.setAttribute('viewBox', `0 0 ${next.width} ${next.height}`);
      set(image, { href: next.file, width: next.width, height: next.height });
      const views = things.flatMap((thing) => {
        const view = viewOf(thing, next.frame);
        return view ? [{ thing, view }] : [];
      });
      element.setAttribute('aria-label', views.length === 0 ? `Picture ${next.frame}, no box yet`
        : `Picture ${next.frame} with ${views.map(({ thing }) => thing.name).join(', ')}`);
      box = views.find(({ thing }) => thing.id === chosen)?.view.box ?? null;
      boxes.replaceChildren(
        ...views.filter(({ thing }) => thing.id !== chosen).map(({ thing, view }) => named(thing, view.box, next, false)),
        ...views.filter(({ thing }) => thing.id === chosen).flatMap(({ thing, view }) =>
          [named(thing, view.box, next, true), ...handles(view.box, next)]));
    },
  };
}

function named(thing: Thing, box: Box, picture: Picture, isChosen: boolean): SVGElement {
  const letters = picture.height / 36;
  const rect = svg('rect', { class: 'box', 'data-thing': thing.id, ...(isChosen ? { 'data-sides': '' } : {}) });
  place(rect, box);
  return svg('g', { class: isChosen ? 'marked chosen' : 'marked' }, rect,
    svg('text', { x: box[0] + letters / 4, y: Math.max(box[1] - letters / 4, letters), 'font-size': letters }, `${thing.id} ${thing.name}`));
}

// Of the chosen box: four corners and four sides, large enough for a finger.
function handles(box: Box, picture: Picture): SVGElement[] {
  const [left, top, right, bottom] = box;
  const half = picture.height / 80;
  const [x, y] = [(left + right) / 2, (top + bottom) / 2];
  const all: [number, number, string][] = [
    [left, top, 'left top'], [x, top, 'top'], [right, top, 'right top'], [right, y, 'right'],
    [right, bottom, 'right bottom'], [x, bottom, 'bottom'], [left, bottom, 'left bottom'], [left, y, 'left'],
  ];
  return all.map(([at, down, sides]) =>
    svg('rect', { class: 'handle', x: at - half, y: down - half, width: 2 * half, height: 2 * half, 'data-sides': sides }));
}

function place(rect: SVGElement, box: Box | null): void {
  rect.setAttribute('visibility', box ? 'visible' : 'hidden');
  if (box) {
    set(rect, { x: box[0], y: box[1], width: box[2] - box[0], height: box[3] - box[1] });
  }
}

function set(element: SVGElement, attributes: Record<string, string | number>): void {
  Object.entries(attributes).forEach(([name, value]) => element.setAttribute(name, String(value)));
}
