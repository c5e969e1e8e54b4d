// The first tap: phones give a page camera, voice and sound only after one.
import { h } from '../shared/dom';
import { radioField } from '../shared/forms';
import { text } from '../shared/texts';
import type { Settings } from './settings';
import { voices } from './settings_dialog';

export function startView(settings: Settings, start: () => void): HTMLElement {
  const choices = voices();
  settings.voice ??= choices[0]?.value === 'own' ? 'own' : 'reader';
  return h('main', { class: 'start' },
    h('h1', {}, 'Roomwise'),
    h('p', { class: 'lead' }, text('start.lead')),
    radioField(text('start.who_speaks'), choices, settings.voice, (voice) => {
      settings.voice = voice as Settings['voice'];
    }),
    h('p', { class: 'hint' }, text('start.camera')),
    h('button', { type: 'button', class: 'primary big', onclick: start }, text('start.start')));
}
