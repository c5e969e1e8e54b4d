// Pictures that the home remembers.
import { at } from '../shared/base';
import { h } from '../shared/dom';
import type { Thing } from '../shared/protocol';
import { svg } from '../shared/svg';
import { formatMoment, text } from '../shared/texts';

export function keyframeAddress(id: number): string {
  return at(`/api/keyframes/${id}/picture`);
}

// `walk`: its name; `time_s`: since it began; `storey`: of a home of several.
export function keyframePicture({ id, walk, time_s, room, storey }: {
  id: number; walk: string; time_s: number; room: string | null; storey?: number | undefined;
}): HTMLElement {
  const values = { walk, time: formatMoment(time_s) };
  const taken = room ? text('picture.of_room', { ...values, room }) : text('picture.of_no_room', values);
  const caption = storey === undefined ? taken : text('picture.on_storey', { picture: taken, number: storey + 1 });
  return h('figure', {}, h('img', { src: keyframeAddress(id), alt: '' }), h('figcaption', {}, caption));
}

// The picture on which the thing is seen best, with its box.
export function thingPicture(thing: Thing): HTMLElement {
  const image = h('img', { src: keyframeAddress(thing.keyframe), alt: text('picture.of_thing', { thing: thing.name }) });
  const frame = h('div', { class: 'boxed' }, image);
  image.addEventListener('load', () => {
    const [left, top, width, height] = thing.box;
    frame.append(svg('svg', { viewBox: `0 0 ${image.naturalWidth} ${image.naturalHeight}`, 'aria-hidden': 'true' },
      ...['under', 'over'].map((kind) => svg('rect', { x: left, y: top, width, height, class: kind }))));
  });
  return frame;
}
