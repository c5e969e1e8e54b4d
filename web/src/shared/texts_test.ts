import assert from 'node:assert/strict';
import { test } from 'node:test';

import en from '../messages/en.json';
import de from '../messages/de.json';
import es from '../messages/es.json';
import fr from '../messages/fr.json';
import { counted, formatMoment, kLanguages, languageOf, setLanguage, text, type TextKey } from './texts';

test('every language has every text with the same values', () => {
  const values = (words: string): string[] => [...words.matchAll(/\{(\w+)\}/g)].map((found) => found[1] ?? '').sort();
  for (const other of [de, es, fr]) {
    assert.deepEqual(Object.keys(other).sort(), Object.keys(en).sort());
    for (const key of Object.keys(en) as TextKey[]) {
      assert.deepEqual(values(other[key]), values(en[key]), key);
      assert.notEqual(other[key].trim(), '', key);
    }
  }
});

test('a language is chosen by what the browser prefers', () => {
  assert.equal(languageOf(['it-IT', 'fr-CA', 'de']), 'fr');
  assert.equal(languageOf(['it']), 'en');
  assert.deepEqual(kLanguages.map(({ value }) => value), ['en', 'de', 'es', 'fr']);
});

test('things are counted by the rule of the language', () => {
  setLanguage('fr');
  assert.equal(counted('home.rooms', 0), '0 pièce');
  assert.equal(counted('home.rooms', 2), '2 pièces');
  setLanguage('es');
  assert.equal(counted('home.rooms', 0), '0 habitaciones');
  assert.equal(counted('home.rooms', 1_000_000), '1.000.000 habitaciones', 'CLDR calls that "many"');
  assert.equal(text('phone.find'), 'Buscar…');
  setLanguage('en');
});

test('a moment of a walk is told in minutes and seconds', () => {
  assert.deepEqual([0, 65.9, 3605].map(formatMoment), ['0:00', '1:05', '1:00:05']);
});

test('German says Sie', () => {
  const familiar = /\b(du|dich|dir|deine?[mnrs]?|(Gib|Nimm|Geh|Halte|Tippe|Sag|Wähle|Setze|Mach|Dreh|Benenne|Lerne|Öffne|Exportiere) (?!Sie))\b/i;
  const texts = Object.entries(de).filter(([, words]) => familiar.test(words));
  assert.deepEqual(texts, []);
});
