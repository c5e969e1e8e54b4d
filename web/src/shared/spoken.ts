// What the phone says by itself, since the computer cannot: of its camera, and that the computer is gone; and
// what it calls the way out and the usual rooms. The words are
// those of the guide's catalogues, so that phone and computer speak alike.
import { goals as deGoals, messages as de, rooms as deRooms } from '../../../roomwise/guide/messages/de.json';
import { goals as enGoals, messages as en, rooms as enRooms } from '../../../roomwise/guide/messages/en.json';
import { goals as esGoals, messages as es, rooms as esRooms } from '../../../roomwise/guide/messages/es.json';
import { goals as frGoals, messages as fr, rooms as frRooms } from '../../../roomwise/guide/messages/fr.json';
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

const rooms: Record<Language, Record<string, { name: string } | undefined>> = { en: enRooms, de: deRooms, es: esRooms, fr: frRooms };

// What a room is called: those that each language has a word for by that, any other as somebody named it.
export function roomCalled(language: Language, name: string): string {
  return rooms[language][name]?.name ?? name;
}

// Said of what need not be so any more.
export function earlier(language: Language, words: string): string {
  return catalogues[language]['repeat.earlier'].replace('{text}', () => words);
}
