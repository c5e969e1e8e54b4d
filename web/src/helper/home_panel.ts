// The home: in three dimensions, and the same in words.
import { ApiError, messageOf, requestBytes } from '../shared/api';
import { h, replaceChildren, setText } from '../shared/dom';
import { textField } from '../shared/forms';
import { counted, text } from '../shared/texts';
import type { View3d } from '../view3d/view3d';
import { mapIsMade, type Helper } from './actions';
import { firstStepsView } from './first_steps';
import { jobView } from './job_view';
import { countOf, outlineOf } from './outline';
import { keyframePicture } from './pictures';
import { editsView } from './plan/edits_view';
import { planView } from './plan/plan_view';
import { rerender } from './rerender';
import { panel } from './shell';
import { outlineView } from './tree_view';

export function homePanel(helper: Helper): HTMLElement {
  return panel(text('nav.home'),
    firstStepsView(helper),
    h('div', { class: 'home' },
      h('div', { class: 'views' }, planView(helper), spaceView(helper)),
      wordsView(helper)));
}

function wordsView(helper: Helper): HTMLElement {
  const { store } = helper;
  const search = textField(text('home.search'), { attributes: { type: 'search' } });
  const count = h('p', { class: 'hint', role: 'status' });
  const tree = h('div', { class: 'tree' });
  const show = (): void => {
    const { home } = store.state;
    if (!home) {
      return;
    }
    const outline = outlineOf(home, search.value());
    rerender(tree, outlineView(helper, home, outline));
    const { rooms, things } = countOf(outline);
    setText(count, `${counted('home.rooms', rooms)}, ${counted('home.things', things)}`);
  };
  search.input.addEventListener('input', show);
  store.watch(['home'], show);
  return h('section', { class: 'words', 'aria-label': text('home.in_words') }, editsView(helper), search.element, count, tree);
}

// Loads three.js only when this part is opened.
function spaceView(helper: Helper): HTMLElement {
  const stage = h('div', { class: 'stage', role: 'img', 'aria-label': text('space.label') });
  const note = h('p', { class: 'hint stage-note' }, text('space.loading'));
  const picture = h('div', { class: 'shown-picture', role: 'status' });
  let pictured: number | null = null; // the key-frame that it shows
  const buttons = h('div', { class: 'row tight', role: 'group', 'aria-label': text('space.controls') });
  const element = h('section', { class: 'space', 'aria-label': text('space.heading') },
    stage, note, jobView(helper, 'map', 'prepare', 'teach', 'erase'), buttons, picture);
  void load();
  return element;

  async function load(): Promise<void> {
    try {
      const { makeView } = await import('../view3d/view3d');
      const view = makeView(stage, {
        keyframeChosen: (keyframe) => {
          const { home, keyframes } = helper.store.state;
          const chosen = keyframes.find((one) => one.id === keyframe);
          if (!chosen) {
            return;
          }
          const began = Math.min(...keyframes.filter((one) => one.recording === chosen.recording).map((one) => one.time_s));
          const walk = home?.recordings.find((one) => one.id === chosen.recording)?.name ?? '';
          replaceChildren(picture, keyframePicture({ ...chosen, walk, time_s: chosen.time_s - began }));
          pictured = keyframe;
        },
        moved: () => refine(),
      });
      addButtons(view);
      helper.store.watch(['home'], () => {
        const { home, keyframes } = helper.store.state;
        if (home) {
          view.setHome(home, keyframes);
        }
        if (!keyframes.some((one) => one.id === pictured)) {
          replaceChildren(picture); // it is forgotten
        }
      });
      helper.store.watch(['seen'], () => view.setSeen([...helper.store.state.seen.values()]));
      const refine = keepCloud(view);
    } catch (error) {
      note.textContent = text('space.not_shown', { why: messageOf(error) });
    }
  }

  // The cloud is there when the map is ready, and another one when a map was made anew. It comes coarsely; what this
  // returns fetches the fine one, which is five times as large, for who looks closer.
  function keepCloud(view: View3d): () => void {
    let shown: 'nothing' | 'nothing yet' | 'coarse' | 'fine' = 'nothing';
    let maps = 0; // what was asked of an earlier one comes too late
    const fetchCloud = (path: string, show: (bytes: ArrayBuffer) => void, failed: (error: unknown) => void): void => {
      const map = maps;
      requestBytes(path).then((bytes) => map === maps && show(bytes), (error: unknown) => map === maps && failed(error));
    };
    helper.store.watch(['job', 'home'], () => {
      const { home } = helper.store.state;
      if (mapIsMade(helper)) {
        maps += 1;
        shown = 'nothing';
        note.textContent = text('space.not_ready');
      } else if (home?.recordings.length === 0) { // nothing yet, or nothing any more
        maps += 1;
        shown = 'nothing';
        view.setCloud(new ArrayBuffer(0));
        note.textContent = text('space.no_map');
      } else if (shown === 'nothing') {
        shown = 'nothing yet';
        fetchCloud('/api/map/cloud', (bytes) => {
          shown = 'coarse';
          view.setCloud(bytes);
          note.textContent = text('space.drag');
        }, (error) => {
          shown = 'nothing';
          const isEarly = error instanceof ApiError && error.status === 503;
          note.textContent = isEarly ? text('space.not_ready') : text('space.not_shown', { why: messageOf(error) });
        });
      }
    });
    return () => {
      if (shown === 'coarse') {
        shown = 'fine';
        fetchCloud('/api/map/cloud/fine', (bytes) => view.refineCloud(bytes), () => (shown = 'coarse'));
      }
    };
  }

  function addButtons(view: View3d): void {
    const button = (label: string, run: () => void): HTMLElement =>
      h('button', { type: 'button', onclick: run }, label);
    replaceChildren(buttons,
      button(text('space.left'), () => view.turn(-20)),
      button(text('space.right'), () => view.turn(20)),
      button(text('space.nearer'), () => view.zoom(0.8)),
      button(text('space.farther'), () => view.zoom(1.25)),
      button(text('space.above'), () => view.fromAbove()));
  }
}
