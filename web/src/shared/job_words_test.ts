import assert from 'node:assert/strict';
import { test } from 'node:test';
import { wordsOfEnd, wordsOfStage } from './job_words';
import type { Job } from './protocol';
import { kLanguages, setLanguage } from './texts';

const ended = (message: string, values: Record<string, number> = {}, kind: Job['kind'] = 'map'): Job => ({
  type: 'job', kind, state: 'done', stage: '', fraction: 1, left_s: null, text: 'the door is red', message, values,
});

test('what a job came to is said in the language of the page, with its numbers', () => {
  const jobs = [
    ended('prepared'), ended('mapped', { placed: 1234, pictures: 2000, things: 7 }), ended('nothing_waited'),
    ended('mapped_damaged', { placed: 1234, pictures: 2000, things: 7, damaged: 3 }), ended('stopped'),
    ended('learned', { rooms: 3, right: 9, tested: 10 }), ended('no_room_named'), ended('one_room'),
    ended('few_pictures', { pictures: 3, wanted: 5 }), ended('no_network'), ended('file_unknown'), ended('no_recording'), ended('several_recordings'),
    ended('file_damaged'), ended('file_unsafe'), ended('walk_known'), ended('taught'), ended('taught_for_later'), ended('looked_for'), ended('name_is_none'), ended('erased'),
    ended('disk_full'), ended('damaged'),
  ];
  const said = new Set<string>();
  for (const { value } of kLanguages) {
    setLanguage(value);
    for (const job of jobs) {
      const words = wordsOfEnd(job);
      assert.match(words, /\.$/, `${job.message} in ${value}`);
      assert.doesNotMatch(words, /[{}]|the door/i, `${job.message} in ${value}`);
      said.add(words);
    }
  }
  assert.equal(said.size, jobs.length * kLanguages.length, 'no two are alike');
  setLanguage('de');
  assert.equal(wordsOfEnd(jobs[1] as Job), 'Bilder mit einem Ort auf der Karte: 1.234 von 2.000. Gefundene Dinge: 7.');
});

test('what a job does now is said in the language of the page', () => {
  setLanguage('de');
  assert.equal(wordsOfStage({ ...ended(''), stage: 'mapping' }), 'Jedes Bild bekommt seinen Ort');
  assert.equal(wordsOfStage({ ...ended(''), stage: 'something new' }), '');
});

test('what the pages have no words for is said as the computer has it', () => {
  setLanguage('en');
  assert.equal(wordsOfEnd(ended('failed')), 'The computer says: The door is red.');
  assert.equal(wordsOfEnd(ended('something new')), 'The computer says: The door is red.');
  assert.equal(wordsOfEnd({ ...ended(''), text: '' }), '');
  setLanguage('fr');
  assert.equal(wordsOfEnd(ended('failed')), "L'ordinateur dit, en anglais : The door is red.");
});

test('one picture is told as one', () => {
  const few = (pictures: number): string => wordsOfEnd(ended('few_pictures', { pictures, wanted: 5 }, 'learn'));
  const said = { en: ['has 1 picture,', 'has 3 pictures,'], de: ['hat 1 Bild,', 'hat 3 Bilder,'], es: ['tiene 1 imagen ', 'tiene 3 imágenes '],
    fr: ['a 1 image,', 'a 3 images,'] };
  for (const { value } of kLanguages) {
    setLanguage(value);
    assert.ok(few(1).includes(said[value][0] ?? '?'), few(1));
    assert.ok(few(3).includes(said[value][1] ?? '?'), few(3));
  }
});

test('a job that was stopped goes on later where it is mapping', () => {
  setLanguage('en');
  assert.equal(wordsOfEnd(ended('stopped')), 'It goes on when the computer starts again.');
  assert.equal(wordsOfEnd(ended('stopped', {}, 'learn')), '');
});
