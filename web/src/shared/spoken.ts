// What the phone says by itself, since the computer cannot: of its camera, and that the computer is gone.
import de from '../messages/spoken_de.json';
import en from '../messages/spoken_en.json';
import type { Language } from './protocol';

export type SpokenKey = keyof typeof en;

const catalogues: Record<Language, Record<SpokenKey, string>> = { en, de };

export function spoken(language: Language, key: SpokenKey): string {
  return catalogues[language][key];
}
