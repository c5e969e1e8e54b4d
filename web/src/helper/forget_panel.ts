// Forgetting a room or a walk, with a way back until they are erased, or everything, which is confirmed by typing the
// home's name.
import { ApiError, request } from '../shared/api';
import { h } from '../shared/dom';
import { selectField, textField, type Field } from '../shared/forms';
import { text } from '../shared/texts';
import { actAndSay, type Helper } from './actions';
import { eraseCard } from './erase_card';
import { takeWalkAway } from './walk_list';
import { card, panel } from './shell';
import { fill } from './walks_panel';

interface Forgetting {
  heading: string;
  explain: string;
  button: string;
  choice: Field | null;
  run: (choice: string, typed: string) => Promise<unknown>;
  done: (choice: string) => string;
}

export function forgetPanel(helper: Helper): HTMLElement {
  const room = selectField(text('forget.which_room'), []);
  const recording = selectField(text('forget.which_walk'), []);
  helper.store.watch(['home'], () => {
    const { rooms = [], recordings = [] } = helper.store.state.home ?? {};
    fill(room.input as HTMLSelectElement, rooms.map(({ name }) => ({ value: name, label: name })));
    fill(recording.input as HTMLSelectElement, recordings.map(({ id, name }) => ({ value: String(id), label: name })));
  });
  const walkName = (id: string): string =>
    helper.store.state.home?.recordings.find((one) => String(one.id) === id)?.name ?? id;
  return panel(text('nav.forget'),
    h('p', { class: 'lead' }, text('forget.lead')),
    eraseCard(helper),
    forgetCard(helper, {
      heading: text('forget.room'), explain: text('forget.room_explain'), button: text('forget.room'), choice: room,
      run: (name) => request('DELETE', `/api/rooms/${encodeURIComponent(name)}`),
      done: (name) => text('forget.room_done', { room: name }),
    }),
    forgetCard(helper, {
      heading: text('forget.walk'), explain: text('forget.walk_explain'), button: text('forget.walk'), choice: recording,
      run: (id) => takeWalkAway(Number(id)),
      done: (id) => text('forget.walk_done', { name: walkName(id) }),
    }),
    forgetCard(helper, {
      heading: text('forget.everything'), explain: text('forget.everything_explain'), button: text('forget.everything'),
      choice: null,
      run: (_, typed) => request('DELETE', '/api/home', { really: typed }),
      done: () => text('forget.everything_done'),
    }));
}

function forgetCard(helper: Helper, options: Forgetting): HTMLElement {
  const home = (): string => helper.store.state.home?.name ?? '';
  const really = textField(text('forget.really'), { hint: text('forget.really_hint', { home: home() }) });
  const form = h('form', { novalidate: true, class: 'form columns' },
    options.choice?.element ?? really.element,
    h('div', { class: 'row' }, h('button', { type: 'submit', class: 'danger' }, options.button)));
  form.addEventListener('submit', (event) => {
    event.preventDefault();
    forget().catch((error: unknown) => (options.choice ?? really).fail(error));
  });

  async function forget(): Promise<void> {
    really.clear();
    options.choice?.clear();
    const choice = options.choice?.value() ?? '';
    if (options.choice && choice === '') {
      options.choice.fail(text('forget.nothing'));
      return;
    }
    if (!options.choice && really.value() !== home()) {
      throw new ApiError(0, text('forget.wrong_name', { home: home() }));
    }
    const done = options.done(choice);
    await actAndSay(helper, async () => {
      await options.run(choice, really.value());
      await helper.store.refreshHome();
    }, done);
    really.input.value = '';
  }
  return card(options.heading, h('p', { class: 'hint' }, options.explain), form);
}
