// What the phone says by itself, since the computer cannot: of its camera, and that the computer is gone; and
// what it calls the way out. The words are
// those of the guide's catalogues, so that phone and computer speak alike.
import { goals as deGoals, messages as de } from '../../../roomwise/guide/messages/de.json';
import { goals as enGoals, messages as en } from '../../../roomwise/guide/messages/en.json';
import { goals as esGoals, messages as es } from '../../../roomwise/guide/messages/es.json';
import { goals as frGoals, messages as fr } from '../../../roomwise/guide/messages/fr.json';
import type { Language } from './protocol';

export type SpokenKey = Extract<keyof typeof en, `device.${string}`>;

const catalogues: Record<Language, Record<SpokenKey | 'repeat.earlier', string>> = { en, de, es, fr };

export function spoken(language: Language, key: SpokenKey): string {
  return catalogues[language][key];
}

const goals = { en: enGoals, de: deGoals, es: esGoals, fr: frGoals };

// What the way out is called.
export function wayOut(language: Language): string {
  return goals[language]['way out'].name;
}

// Said of what need not be so any more.
export function earlier(language: Language, words: string): string {
  return catalogues[language]['repeat.earlier'].replace('{text}', () => words);
}
