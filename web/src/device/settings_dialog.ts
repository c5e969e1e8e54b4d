// How the phone speaks and measures.
import { openDialog } from '../shared/dialog';
import { h } from '../shared/dom';
import { openFormDialog } from '../shared/form_dialog';
import { checkField, radioField } from '../shared/forms';
import { languageChoice } from '../shared/language_choice';
import { formatNumber, language, text } from '../shared/texts';
import { kRates, kSteps, type Settings } from './settings';
import { OwnVoice } from './speaker';

export interface SettingsActions {
  changed: () => void; // `settings` holds what was chosen
  leave: () => Promise<() => void>; // gives what says that it is done
}

export function openSettings(settings: Settings, actions: SettingsActions): void {
  const set = <Name extends keyof Settings>(name: Name) => (value: Settings[Name]): void => {
    settings[name] = value;
    actions.changed();
  };
  openDialog(text('settings.title'), [
    radioField(text('settings.voice'), voices(), settings.voice, (voice) => set('voice')(voice as Settings['voice'])),
    slider(text('settings.rate'), kRates, 0.1, settings.rate, (rate) => `${formatNumber(rate, 1)}×`, set('rate')),
    radioField(text('settings.distances'), [
      { value: 'metres', label: text('settings.metres') },
      { value: 'steps', label: text('settings.steps') },
    ], settings.distances, (distances) => set('distances')(distances as Settings['distances'])),
    slider(text('settings.step'), kSteps, 0.05, settings.step_m,
      (metres) => `${formatNumber(Math.round(100 * metres))} cm`, set('step_m')),
    checkField(text('settings.callouts'), settings.callouts, set('callouts')).element,
    checkField(text('settings.sounds'), settings.sounds, set('sounds')).element,
    'vibrate' in navigator
      ? checkField(text('settings.vibration'), settings.vibration, set('vibration')).element : null,
    checkField(text('settings.aim'), settings.aim, set('aim')).element,
    checkField(text('settings.may_watch'), settings.mayWatch, set('mayWatch')).element,
    h('p', { 'aria-hidden': 'true' }, text('settings.language')),
    languageChoice(),
    h('p', {}, h('a', { href: `/help/manual/card.${language()}.html` }, text('settings.help'))),
    h('button', { type: 'button', class: 'danger', onclick: () => confirmLeaving(actions) }, text('settings.leave')),
  ]);
}

function confirmLeaving({ leave }: SettingsActions): void {
  openFormDialog({
    title: text('settings.leave_title'), explain: text('settings.leave_explain'), fields: [], submit: text('settings.leave'),
    dangerous: true, run: leave,
  });
}

export function voices(): { value: string; label: string }[] {
  return [
    ...(OwnVoice.available() ? [{ value: 'own', label: text('voice.own') }] : []),
    { value: 'reader', label: text('voice.reader') },
  ];
}

function slider(
  label: string, limits: { least: number; most: number }, step: number, value: number,
  shown: (value: number) => string, changed: (value: number) => void,
): HTMLElement {
  const input = h('input', { type: 'range', min: limits.least, max: limits.most, step });
  const output = h('span', { class: 'slider-value', 'aria-hidden': 'true' });
  const show = (): void => {
    output.textContent = shown(input.valueAsNumber);
    input.setAttribute('aria-valuetext', output.textContent);
  };
  input.value = String(value);
  input.addEventListener('input', show);
  input.addEventListener('change', () => changed(input.valueAsNumber));
  show();
  return h('label', { class: 'slider' }, h('span', {}, label), input, output);
}
