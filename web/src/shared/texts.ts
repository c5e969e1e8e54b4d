// The words of the pages, in the language that was chosen.
import de from '../messages/de.json';
import en from '../messages/en.json';
import es from '../messages/es.json';
import fr from '../messages/fr.json';
import type { Language } from './protocol';
import { spoken, type SpokenKey } from './spoken';

export type TextKey = keyof typeof en;
type Values = Record<string, string | number>;

const catalogues: Record<Language, Record<TextKey, string>> = { en, de, es, fr };
export const kLanguages: readonly { value: Language; label: string }[] = [
  { value: 'en', label: 'English' }, { value: 'de', label: 'Deutsch' }, { value: 'es', label: 'Español' }, { value: 'fr', label: 'Français' },
];
const kStored = 'roomwise.language';
let chosen: Language = 'en';

export function languageOf(tags: readonly string[]): Language {
  const known = tags.map((tag) => tag.slice(0, 2).toLowerCase());
  return known.find(isLanguage) ?? 'en';
}

function isLanguage(tag: string | null): tag is Language {
  return kLanguages.some(({ value }) => value === tag);
}

// What was chosen before, else what the browser prefers.
export function chooseLanguage(): Language {
  const stored = window.localStorage.getItem(kStored);
  setLanguage(isLanguage(stored) ? stored : languageOf(navigator.languages));
  return chosen;
}

export function setLanguage(language: Language): void {
  chosen = language;
  if (typeof document !== 'undefined') {
    document.documentElement.lang = language;
  }
}

export function rememberLanguage(language: Language): void {
  window.localStorage.setItem(kStored, language);
  setLanguage(language);
}

export function language(): Language {
  return chosen;
}

export function text(key: TextKey, values: Values = {}): string {
  return filled(catalogues[chosen][key], values);
}

// `count` chooses between the texts `key.one` and `key.other`, by the language's rule: 0 is singular in French.
export function counted(
  key: TextKey extends infer Key ? (Key extends `${infer Stem}.other` ? Stem : never) : never,
  count: number,
  values: Values = {},
): string {
  const form = new Intl.PluralRules(chosen).select(count) === 'one' ? 'one' : 'other';
  return text(`${key}.${form}` as TextKey, { count: formatNumber(count), ...values });
}

// A message that the phone speaks by itself.
export function spokenText(key: SpokenKey): string {
  return spoken(chosen, key);
}

export function filled(pattern: string, values: Values): string {
  return pattern.replace(/\{(\w+)\}/g, (whole, name: string) => {
    const value = values[name];
    return value === undefined ? whole : String(value);
  });
}

export function formatNumber(value: number, digits = 0): string {
  return new Intl.NumberFormat(chosen, { maximumFractionDigits: digits }).format(value);
}

export function formatPercent(value: number): string {
  return new Intl.NumberFormat(chosen, { style: 'percent' }).format(value);
}

// Of a walk: minutes and seconds from its beginning, "1:05".
export function formatMoment(seconds: number): string {
  const whole = Math.max(0, Math.floor(seconds));
  const two = (value: number): string => String(value).padStart(2, '0');
  const [hours, minutes] = [Math.floor(whole / 3600), Math.floor(whole / 60) % 60];
  return hours > 0 ? `${hours}:${two(minutes)}:${two(whole % 60)}` : `${minutes}:${two(whole % 60)}`;
}

export function formatTime(seconds: number): string {
  const format = new Intl.DateTimeFormat(chosen, { dateStyle: 'medium', timeStyle: 'short' });
  return format.format(new Date(seconds * 1000));
}
