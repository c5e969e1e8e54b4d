// The labelling page: a person draws boxes about the things in a recording's pictures. It is opened as a file, speaks with nobody, and keeps
// what was drawn in this browser until it is saved as a file. roomwise-lab label writes the folder, recording.js among it.
import { Announcer } from '../shared/announcer';
import { append, byId, h, newId, replaceChildren } from '../shared/dom';
import { checkField, textField } from '../shared/forms';
import { svg } from '../shared/svg';
import {
  kBorders, kSides, moved, noLabels, parseLabels, textOf, viewOf, whatIsMissing, withBox, withChange, withNewThing, withoutBox, withoutThing,
  withSide, withViewChange, type Border, type Box, type LabelledRecording, type Labels, type Picture, type Thing,
} from './labels';
import { pictureView } from './picture_view';

declare global {
  interface Window {
    recording?: LabelledRecording; // by recording.js
    labels?: unknown; // that the page begins with
  }
}

const kArrows: Record<string, readonly [number, number]> = { ArrowLeft: [-1, 0], ArrowRight: [1, 0], ArrowUp: [0, -1], ArrowDown: [0, 1] };

function start(recording: LabelledRecording): void {
  const kept = `roomwise labels of ${recording.name}`;
  let labels: Labels = noLabels(recording.name, 'A');
  let before: Labels[] = []; // for undo
  let chosen: number | null = null;
  let at = 0;
  const announcer = new Announcer();
  const picture = (): Picture => recording.pictures[at] as Picture;
  const thing = (): Thing | undefined => labels.things.find(({ id }) => id === chosen);
  const box = (): Box | undefined => {
    const now = thing();
    return now && viewOf(now, picture().frame)?.box;
  };

  const change = (next: Labels, words = ''): void => {
    before.push(labels);
    become(next);
    if (words !== '') {
      announcer.say(words);
    }
  };
  const become = (next: Labels): void => {
    labels = next;
    chosen = labels.things.some(({ id }) => id === chosen) ? chosen : null;
    try {
      localStorage.setItem(kept, textOf(labels));
    } catch {
      announcer.say('This browser cannot keep what you draw: save the file often.', 'failed');
    }
    show();
  };

  const view = pictureView({
    drawn: (drawn) => {
      const now = thing();
      if (now) {
        change(withBox(labels, now.id, picture(), drawn));
      } else {
        announcer.say('Choose a thing, or add one, before you draw its box.', 'failed');
      }
    },
    chosen: (id) => {
      chosen = id;
      show();
    },
  });

  const reader = textField('Reader', { hint: 'One word, the same every time: it is part of the name of the file.' });
  reader.input.addEventListener('change', () => change({ ...labels, reader: reader.value() || 'A' }));
  const words = h('datalist', { id: newId('words') }, ...recording.words.map((word) => h('option', { value: word })));
  const name = textField('Name of the new thing', { attributes: { list: words.id } });
  const add = h('form', { class: 'add' }, name.element, h('button', {}, 'Add the thing'));
  add.addEventListener('submit', (event) => {
    event.preventDefault();
    if (name.value() === '') {
      name.fail('Say what it is.');
      return;
    }
    name.clear();
    const next = withNewThing(labels, name.value());
    chosen = next.things[next.things.length - 1]?.id ?? null;
    (name.input as HTMLInputElement).value = '';
    change(next, 'Added. Draw its box on the picture.');
  });

  const place = h('p', { class: 'place' });
  const slider = h('input', { type: 'range', min: 0, max: recording.pictures.length - 1, step: 1, 'aria-label': 'Picture' });
  const go = (to: number): void => {
    at = Math.min(Math.max(to, 0), recording.pictures.length - 1);
    show();
  };
  slider.addEventListener('input', () => go(Number(slider.value)));
  const undo = h('button', { type: 'button' }, 'Undo');
  undo.addEventListener('click', () => {
    const last = before.pop();
    if (last) {
      become(last);
    }
  });
  const save = h('button', { type: 'button', class: 'primary' }, 'Save the file');
  save.addEventListener('click', () => {
    const link = h('a', {
      href: URL.createObjectURL(new Blob([textOf(labels)], { type: 'application/json' })),
      download: `${recording.name}.reader-${labels.reader.toLowerCase()}.json`,
    });
    link.click();
    const missing = whatIsMissing(labels);
    announcer.say(missing.length === 0 ? 'Saved.' : `Saved, but not complete. ${missing.join(' ')}`, missing.length === 0 ? 'done' : 'failed');
  });
  const open = h('input', { type: 'file', accept: '.json,application/json', id: newId('open') });
  open.addEventListener('change', () => {
    const file = open.files?.[0];
    void file?.text().then((text) => {
      change(parseLabels(text, recording), 'Opened.');
    }).catch((error: unknown) => announcer.say((error as Error).message, 'failed')).finally(() => {
      open.value = '';
    });
  });

  const list = h('ul', { class: 'things' });
  const details = h('div', { class: 'details' });
  const views = h('ul', { class: 'views' });

  function show(): void {
    const now = picture();
    view.show(now, labels.things, chosen);
    slider.value = String(at);
    slider.setAttribute('aria-valuetext', `picture ${at + 1} of ${recording.pictures.length}`);
    place.textContent = `Picture ${at + 1} of ${recording.pictures.length} (frame ${now.frame})`;
    (reader.input as HTMLInputElement).value = labels.reader;
    undo.toggleAttribute('disabled', before.length === 0);
    const focused = document.activeElement?.id;
    replaceChildren(list, ...labels.things.map(thingButton));
    replaceChildren(details, ...detailsOf(thing()));
    replaceChildren(views, ...(thing()?.views ?? []).map(viewButton));
    // What was made anew has its id of before, so that the keyboard stays where it was.
    if (focused && document.activeElement === document.body) {
      document.getElementById(focused)?.focus();
    }
  }

  function thingButton(one: Thing): HTMLElement {
    const isHere = viewOf(one, picture().frame) !== undefined;
    const button = h('button', { type: 'button', id: `thing-${one.id}`, 'aria-pressed': String(one.id === chosen) },
      `${one.id} ${one.name}`, h('span', { class: 'count' }, ` ${one.views.length}${isHere ? ', here' : ''}`));
    button.addEventListener('click', () => {
      chosen = one.id;
      show();
    });
    return h('li', {}, button);
  }

  // A look at each box of the chosen thing, to tell whether it is one and the same thing.
  function viewButton({ frame, box: [left, top, right, bottom] }: Thing['views'][number]): HTMLElement {
    const shown = recording.pictures.findIndex((one) => one.frame === frame);
    const of = recording.pictures[shown];
    if (!of) {
      return h('li', {}, `frame ${frame}, not among these pictures`);
    }
    const margin = 0.15 * Math.max(right - left, bottom - top);
    const look = svg('svg', {
      viewBox: `${left - margin} ${top - margin} ${right - left + 2 * margin} ${bottom - top + 2 * margin}`, 'aria-hidden': 'true',
    }, svg('image', { href: of.file, width: of.width, height: of.height }));
    const button = h('button', { type: 'button', id: `view-${frame}`, 'aria-current': frame === picture().frame ? 'true' : null },
      look, `frame ${frame}`);
    button.addEventListener('click', () => go(shown));
    return h('li', {}, button);
  }

  function detailsOf(now: Thing | undefined): HTMLElement[] {
    if (!now) {
      return [h('p', { class: 'hint' }, labels.things.length === 0
        ? 'Add the first thing that you see, then drag from corner to corner of what is visible of it.'
        : 'Choose a thing to draw or correct its box.')];
    }
    const called = textField('Name', { value: now.name, attributes: { list: words.id, id: 'name' } });
    called.input.addEventListener('change', () => change(withChange(labels, now.id, { name: called.value() })));
    const note = textField('Where it stands', { value: now.note });
    note.input.addEventListener('change', () => change(withChange(labels, now.id, { note: note.value() })));
    const flags = [
      checkField('Sure of the name', now.sure, (sure) => change(withChange(labels, now.id, { sure }))),
      checkField('A person, or carried by one', now.transient, (transient) => change(withChange(labels, now.id, { transient }))),
    ];
    const sides = h('fieldset', {}, h('legend', {}, 'Sides that are seen'), ...kSides.map((side) =>
      checkField(side, now.side.includes(side), (seen) => change(withChange(labels, now.id, {
        side: kSides.filter((one) => (one === side ? seen : now.side.includes(one))),
      }))).element));
    const remove = h('button', { type: 'button', class: 'danger' }, 'Remove the thing');
    remove.addEventListener('click', () => change(withoutThing(labels, now.id), `Removed ${now.name}. Undo brings it back.`));
    return [h('h2', {}, `${now.id} ${now.name}`), ...boxDetails(now), called.element, note.element, ...flags.map(({ element }) => element),
      sides, remove];
  }

  function boxDetails(now: Thing): HTMLElement[] {
    const { frame } = picture();
    const seen = viewOf(now, frame);
    if (!seen) {
      const draw = h('button', { type: 'button', id: 'box' }, 'Put a box in the middle');
      const { width, height } = picture();
      draw.addEventListener('click', () =>
        change(withBox(labels, now.id, picture(), [0.4 * width, 0.4 * height, 0.6 * width, 0.6 * height])));
      return [h('p', {}, 'No box in this picture.'), draw];
    }
    const adjust = h('button', {
      type: 'button', id: 'box', 'aria-describedby': 'box-keys',
    }, `Box ${seen.box.join(', ')}`);
    adjust.addEventListener('keydown', adjustByKey);
    const cut = h('fieldset', {}, h('legend', {}, 'Cut by the border'), ...kBorders.map((border) =>
      checkField(border, seen.cut.includes(border), (is) => change(withViewChange(labels, now.id, frame, {
        cut: kBorders.filter((one): one is Border => (one === border ? is : seen.cut.includes(one))),
      }))).element));
    const occluded = checkField('Partly hidden by another thing', seen.occluded, (is) =>
      change(withViewChange(labels, now.id, frame, { occluded: is })));
    return [adjust, h('p', { id: 'box-keys', class: 'hint' },
      'Arrow keys move the box, with Shift its right and lower side, with Alt its left and upper side, with Ctrl ten times as far. Delete takes it away.'),
    cut, occluded.element];
  }

  function adjustByKey(event: KeyboardEvent): void {
    const now = thing();
    const old = box();
    if (!now || !old) {
      return;
    }
    const step = kArrows[event.key];
    if (step) {
      const by = event.ctrlKey ? 10 : 1;
      const [dx, dy] = [step[0] * by, step[1] * by];
      const side: Border = dx !== 0 ? (event.altKey ? 'left' : 'right') : event.altKey ? 'top' : 'bottom';
      const next = event.shiftKey || event.altKey ? withSide(old, side, dx + dy, picture()) : moved(old, dx, dy, picture());
      event.preventDefault();
      change(withBox(labels, now.id, picture(), next));
    } else if (event.key === 'Delete') {
      event.preventDefault();
      change(withoutBox(labels, now.id, picture().frame), 'The box is away. Undo brings it back.');
    }
  }

  const step = (words: string, by: number): HTMLElement => {
    const button = h('button', { type: 'button' }, words);
    button.addEventListener('click', () => go(at + by));
    return button;
  };
  append(byId('page'), [
    h('header', { class: 'bar' }, h('h1', {}, `Things in ${recording.name}`),
      h('div', { class: 'actions' }, undo, save, h('label', { for: open.id }, 'Go on from a file'), open)),
    h('main', {},
      h('section', { 'aria-label': 'Picture', class: 'stage' },
        h('div', { class: 'steps' }, step('Before', -1), slider, step('Next', 1)), place, view.element, views),
      h('section', { 'aria-label': 'Things', class: 'side' }, reader.element, add, words, list, details)),
    announcer.element,
  ]);

  const begin = (text: string | null): boolean => {
    try {
      if (text !== null) {
        labels = parseLabels(text, recording);
      }
      return text !== null;
    } catch (error) {
      announcer.say((error as Error).message, 'failed');
      return false;
    }
  };
  // What was drawn here goes before what the page was made with.
  if (!begin(localStorage.getItem(kept)) && window.labels !== undefined) {
    begin(JSON.stringify(window.labels));
  }
  show();
}

if (window.recording && window.recording.pictures.length > 0) {
  start(window.recording);
} else {
  append(byId('page'), [h('main', {}, h('p', {}, 'There are no pictures here. roomwise-lab label RECORDING -o FOLDER makes a folder with them.'))]);
}
