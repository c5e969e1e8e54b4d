// What a reader marks in the pictures of a recording, as roomwise-lab lift-labels reads it
// (tests/truth/labels/README.md). Values: a change makes new ones. Pure.

export const kBorders = ['left', 'top', 'right', 'bottom'] as const;
export type Border = (typeof kBorders)[number];
export type Box = readonly [left: number, top: number, right: number, bottom: number]; // px of the picture's file

export interface View {
  frame: number;
  box: Box;
  cut: readonly Border[]; // borders of the picture that cut the thing
  occluded: boolean; // another thing hides a part of it
}

export interface Thing {
  id: number;
  name: string;
  sure: boolean; // of the name
  side: readonly string[]; // that was seen
  views: readonly View[];
  note: string;
  transient: boolean; // a person: no thing of the home
}

export interface Labels {
  recording: string;
  reader: string;
  how: string;
  things: readonly Thing[];
}

export interface Picture {
  frame: number;
  file: string;
  width: number; // px
  height: number;
}

export interface LabelledRecording {
  name: string;
  pictures: readonly Picture[]; // in the order of time
  words: readonly string[]; // that the home has for things
}

export const kSides = ['front', 'back', 'left', 'right', 'top', 'bottom'] as const;

export function noLabels(recording: string, reader: string): Labels {
  return { recording, reader, how: 'boxes drawn on the pictures by roomwise-lab label', things: [] };
}

export function withNewThing(labels: Labels, name: string): Labels {
  const id = 1 + Math.max(0, ...labels.things.map((thing) => thing.id));
  const thing: Thing = { id, name, sure: true, side: ['front'], views: [], note: '', transient: false };
  return { ...labels, things: [...labels.things, thing] };
}

export function withoutThing(labels: Labels, id: number): Labels {
  return { ...labels, things: labels.things.filter((thing) => thing.id !== id) };
}

export function withChange(labels: Labels, id: number, change: Partial<Omit<Thing, 'id' | 'views'>>): Labels {
  return withThing(labels, id, (thing) => ({ ...thing, ...change }));
}

export function viewOf(thing: Thing, frame: number): View | undefined {
  return thing.views.find((view) => view.frame === frame);
}

// The thing's one box in that picture: a new one takes the old one's place. Borders that it touches cut it.
export function withBox(labels: Labels, id: number, picture: Picture, drawn: Box): Labels {
  const box = rounded(drawn, picture);
  return withThing(labels, id, (thing) => {
    const view: View = {
      frame: picture.frame, box, cut: bordersOf(box, picture), occluded: viewOf(thing, picture.frame)?.occluded ?? false,
    };
    const others = thing.views.filter((other) => other.frame !== picture.frame);
    return { ...thing, views: [...others, view].sort((a, b) => a.frame - b.frame) };
  });
}

export function withoutBox(labels: Labels, id: number, frame: number): Labels {
  return withThing(labels, id, (thing) => ({ ...thing, views: thing.views.filter((view) => view.frame !== frame) }));
}

export function withViewChange(labels: Labels, id: number, frame: number, change: Partial<Pick<View, 'cut' | 'occluded'>>): Labels {
  return withThing(labels, id, (thing) => ({
    ...thing, views: thing.views.map((view) => (view.frame === frame ? { ...view, ...change } : view)),
  }));
}

export function bordersOf(box: Box, { width, height }: Picture): Border[] {
  const near = 1; // px
  return [
    ...(box[0] <= near ? ['left' as const] : []), ...(box[1] <= near ? ['top' as const] : []),
    ...(box[2] >= width - near ? ['right' as const] : []), ...(box[3] >= height - near ? ['bottom' as const] : []),
  ];
}

// Moved as it is, or by one side alone, and kept within the picture, one px large at least.
export function moved(box: Box, dx: number, dy: number, { width, height }: Picture): Box {
  const x = clamp(dx, -box[0], width - box[2]);
  const y = clamp(dy, -box[1], height - box[3]);
  return [box[0] + x, box[1] + y, box[2] + x, box[3] + y];
}

export function withSide(box: Box, side: Border, by: number, { width, height }: Picture): Box {
  const [left, top, right, bottom] = box;
  switch (side) {
    case 'left': return [clamp(left + by, 0, right - 1), top, right, bottom];
    case 'top': return [left, clamp(top + by, 0, bottom - 1), right, bottom];
    case 'right': return [left, top, clamp(right + by, left + 1, width), bottom];
    case 'bottom': return [left, top, right, clamp(bottom + by, top + 1, height)];
  }
}

// Between two points, in whichever order; null where it is too thin to be meant.
export function boxBetween(x0: number, y0: number, x1: number, y1: number): Box | null {
  const least = 3; // px
  const box: Box = [Math.min(x0, x1), Math.min(y0, y1), Math.max(x0, x1), Math.max(y0, y1)];
  return box[2] - box[0] >= least && box[3] - box[1] >= least ? box : null;
}

// What is still to be done before the file is of use, a sentence each.
export function whatIsMissing(labels: Labels): string[] {
  return labels.things.flatMap((thing) => [
    ...(thing.name.trim() === '' ? [`Thing ${thing.id} has no name.`] : []),
    ...(thing.views.length === 0 ? [`Thing ${thing.id} (${thing.name}) has no box.`] : []),
  ]);
}

export function textOf(labels: Labels): string {
  const things = labels.things.map((thing) => JSON.stringify(thing));
  const { recording, reader, how } = labels;
  const head = JSON.stringify({ recording, reader, how }).slice(0, -1);
  return `${head},\n"things": [${things.length > 0 ? `\n${things.join(',\n')}\n` : ''}]}\n`;
}

// Throws an Error in words where the text is no such file, or of another recording.
export function parseLabels(text: string, recording: LabelledRecording): Labels {
  let read: Partial<Labels>;
  try {
    read = JSON.parse(text) as Partial<Labels>;
  } catch {
    throw new Error('This file is no JSON: choose a file that this page saved.');
  }
  if (typeof read !== 'object' || read === null || !Array.isArray(read.things) || typeof read.reader !== 'string') {
    throw new Error('This file has no reader and things: choose a file that this page saved.');
  }
  if (read.recording !== recording.name) {
    throw new Error(`This file belongs to the recording ${String(read.recording)}, not to ${recording.name}.`);
  }
  const sizes = new Map(recording.pictures.map((picture) => [picture.frame, picture]));
  return {
    ...noLabels(recording.name, read.reader),
    ...(typeof read.how === 'string' ? { how: read.how } : {}),
    things: read.things.map((thing: Partial<Thing>) => thingOf(thing, sizes)),
  };
}

function thingOf(read: Partial<Thing>, pictures: ReadonlyMap<number, Picture>): Thing {
  if (typeof read.id !== 'number' || typeof read.name !== 'string' || !Array.isArray(read.views)) {
    throw new Error(`A thing of this file has no id, name or views: ${JSON.stringify(read).slice(0, 80)}`);
  }
  return {
    id: read.id, name: read.name, sure: read.sure ?? true, side: read.side ?? [], note: read.note ?? '',
    transient: read.transient ?? false,
    views: read.views.map((view: Partial<View>) => {
      const box = view.box;
      if (typeof view.frame !== 'number' || !Array.isArray(box) || box.length !== 4 || !box.every(Number.isFinite)) {
        throw new Error(`Thing ${read.id} of this file has a view without frame or box.`);
      }
      const picture = pictures.get(view.frame);
      const sides = box as unknown as Box;
      return {
        frame: view.frame, box: sides, cut: view.cut ?? (picture ? bordersOf(sides, picture) : []), occluded: view.occluded ?? false,
      };
    }),
  };
}

function withThing(labels: Labels, id: number, change: (thing: Thing) => Thing): Labels {
  return { ...labels, things: labels.things.map((thing) => (thing.id === id ? change(thing) : thing)) };
}

function rounded(box: Box, { width, height }: Picture): Box {
  const x = (value: number): number => clamp(Math.round(value), 0, width);
  const y = (value: number): number => clamp(Math.round(value), 0, height);
  return [x(box[0]), y(box[1]), x(box[2]), y(box[3])];
}

function clamp(value: number, least: number, most: number): number {
  return Math.min(Math.max(value, least), most);
}
