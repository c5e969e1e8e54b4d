// The home: in three dimensions, and the same in words.
import { messageOf, requestBytes } from '../shared/api';
import { h, replaceChildren } from '../shared/dom';
import { textField } from '../shared/forms';
import { counted, text } from '../shared/texts';
import type { View3d } from '../view3d/view3d';
import type { Helper } from './actions';
import { countOf, outlineOf } from './outline';
import { keyframePicture } from './pictures';
import { rerender } from './rerender';
import { panel } from './shell';
import { outlineView } from './tree_view';

export function homePanel(helper: Helper): HTMLElement {
  return panel(text('nav.home'),
    h('div', { class: 'home' }, spaceView(helper), wordsView(helper)));
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
    const words = `${counted('home.rooms', rooms)}, ${counted('home.things', things)}`;
    if (count.textContent !== words) {
      count.textContent = words;
    }
  };
  search.input.addEventListener('input', show);
  store.watch(['home'], show);
  return h('section', { class: 'words', 'aria-label': text('home.in_words') }, search.element, count, tree);
}

// Loads three.js only when this part is opened.
function spaceView(helper: Helper): HTMLElement {
  const stage = h('div', { class: 'stage', role: 'img', 'aria-label': text('space.label') });
  const note = h('p', { class: 'hint stage-note' }, text('space.loading'));
  const picture = h('div', { class: 'shown-picture', role: 'status' });
  const buttons = h('div', { class: 'row tight', role: 'group', 'aria-label': text('space.controls') });
  const element = h('section', { class: 'space', 'aria-label': text('space.heading') }, stage, note, buttons, picture);
  void load();
  return element;

  async function load(): Promise<void> {
    try {
      const { makeView } = await import('../view3d/view3d');
      const view = makeView(stage, (keyframe) => {
        const room = helper.store.state.keyframes.find((one) => one.id === keyframe)?.room ?? null;
        replaceChildren(picture, keyframePicture(keyframe, room));
      });
      addButtons(view);
      helper.store.watch(['home'], () => {
        const { home, keyframes } = helper.store.state;
        if (home) {
          view.setHome(home, keyframes);
        }
      });
      helper.store.watch(['seen'], () => view.setSeen([...helper.store.state.seen.values()]));
      note.textContent = text('space.drag');
      view.setCloud(await requestBytes('/api/map/cloud'));
    } catch (error) {
      note.textContent = text('space.not_shown', { why: messageOf(error) });
    }
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
