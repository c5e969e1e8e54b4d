// Walks: recording a new one, naming rooms on those that are there.
import { h } from '../shared/dom';
import { selectField } from '../shared/forms';
import type { Me } from '../shared/protocol';
import { text } from '../shared/texts';
import { mapIsMade, type Helper } from './actions';
import { changesCard } from './changes_card';
import { coverageCard } from './coverage_card';
import { namingView } from './naming_view';
import { recordCard } from './record_card';
import { card, panel } from './shell';
import { uploadCard } from './upload_card';
import { walkListCard } from './walk_list';

export function walksPanel(helper: Helper, me: Me): HTMLElement {
  const { store } = helper;
  const place = h('div', { class: 'naming' });
  let shown: { id: number; view: ReturnType<typeof namingView> } | null = null;

  const choice = selectField(text('walks.which'), []);
  choice.input.addEventListener('change', () => show());
  const show = (): void => {
    const recordings = store.state.home?.recordings ?? [];
    fill(choice.input as HTMLSelectElement, recordings.map(({ id, name }) => ({ value: String(id), label: name })));
    choice.element.hidden = recordings.length < 2;
    const recording = recordings.find((one) => String(one.id) === choice.value());
    if (!recording) {
      shown = null;
      place.textContent = text('walks.none');
      return;
    }
    if (shown?.id !== recording.id) {
      shown = { id: recording.id, view: namingView(helper) };
      place.textContent = '';
      place.append(shown.view.element);
    }
    shown.view.show(recording, store.state.keyframes.filter((one) => one.recording === recording.id));
  };
  store.watch(['home'], show);
  let isMade = mapIsMade(helper); // how far it is changes nothing here
  store.watch(['job'], () => {
    if (isMade !== mapIsMade(helper)) {
      isMade = mapIsMade(helper);
      show();
    }
  });
  return panel(text('nav.walks'),
    card(text('walks.name_rooms'), h('p', { class: 'hint' }, text('walks.explain')), choice.element, place),
    walkListCard(helper), changesCard(helper), coverageCard(helper), recordCard(helper, me), uploadCard(helper));
}

// Keeps what was chosen, where it is still there.
export function fill(select: HTMLSelectElement, choices: readonly { value: string; label: string }[]): void {
  const same = choices.length === select.options.length
    && choices.every((one, i) => select.options[i]?.value === one.value && select.options[i]?.label === one.label);
  if (same) {
    return;
  }
  const chosen = select.value;
  select.textContent = '';
  select.append(...choices.map((one) => h('option', { value: one.value }, one.label)));
  if (choices.some((one) => one.value === chosen)) {
    select.value = chosen;
  }
}
