// What the phone says by itself, since the computer cannot: of its camera, and that the computer is gone. The words are
// those of the guide's catalogues, so that phone and computer speak alike.
import { messages as de } from '../../../roomwise/guide/messages/de.json';
import { messages as en } from '../../../roomwise/guide/messages/en.json';
import { messages as es } from '../../../roomwise/guide/messages/es.json';
import { messages as fr } from '../../../roomwise/guide/messages/fr.json';
import type { Language } from './protocol';

export type SpokenKey = Extract<keyof typeof en, `device.${string}`>;

const catalogues: Record<Language, Record<SpokenKey, string>> = { en, de, es, fr };

export function spoken(language: Language, key: SpokenKey): string {
  return catalogues[language][key];
}
