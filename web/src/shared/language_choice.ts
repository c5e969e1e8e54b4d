// The page's other languages, each by its own name. Buttons, since the page is loaded anew: with radio buttons or a list the
// keys that only look through them would already change it.
import { h } from './dom';
import type { Language } from './protocol';
import { kLanguages, language, rememberLanguage, text } from './texts';

export function languageChoice(): HTMLElement {
  const change = (chosen: Language): void => {
    rememberLanguage(chosen);
    location.reload();
  };
  const others = kLanguages.filter(({ value }) => value !== language());
  return h('div', { class: 'languages', role: 'group', 'aria-label': text('settings.language') },
    ...others.map(({ value, label }) =>
      h('button', { type: 'button', class: 'language quiet-button', lang: value, onclick: () => change(value) }, label)));
}
