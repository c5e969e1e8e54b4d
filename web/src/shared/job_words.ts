// What came of the computer's long work, in the page's language.
import type { Job } from './protocol';
import { counted, formatNumber, text, type TextKey } from './texts';

const kEnds: Record<string, TextKey> = {
  prepared: 'job.end.prepared', mapped: 'job.end.mapped', mapped_damaged: 'job.end.mapped_damaged', nothing_waited: 'job.end.nothing_waited',
  learned: 'job.end.learned', no_room_named: 'job.end.no_room_named', one_room: 'job.end.one_room',
  no_network: 'job.end.no_network', file_unknown: 'job.end.file_unknown', no_recording: 'job.end.no_recording',
  several_recordings: 'job.end.several_recordings', file_damaged: 'job.end.file_damaged', file_unsafe: 'job.end.file_unsafe', walk_known: 'job.end.walk_known',
  taught: 'job.end.taught', taught_for_later: 'job.end.taught_for_later', looked_for: 'job.end.looked_for', name_is_none: 'job.end.name_is_none',
  erased: 'job.end.erased',
  disk_full: 'job.end.disk_full', damaged: 'job.end.damaged',
};

const kStages: Record<string, TextKey> = {
  unpacking: 'job.stage.unpack', 'loading the map': 'job.stage.load', mapping: 'job.stage.place', 'looking at key-frames': 'job.stage.things',
  'checking the camera': 'job.stage.adjust', 'adjusting landmarks': 'job.stage.adjust', 'finding features again': 'job.stage.find_again',
  'fusing the map': 'job.stage.join', 'fusing depth between pictures': 'job.stage.join',
  'looking at what is usual': 'job.stage.taught', 'comparing with what was taught': 'job.stage.taught', 'looking for what was taught': 'job.stage.taught',
};

// What a job that runs does now; empty where its kind says all.
export function wordsOfStage(job: Job): string {
  const key = kStages[job.stage];
  return key === undefined ? '' : text(key);
}

// Behind `job.KIND_STATE`; empty where that says all. What the pages have no words for stands as the computer has it, in English.
export function wordsOfEnd(job: Job): string {
  if (job.message === 'stopped') {
    return job.kind === 'map' ? text('job.end.goes_on') : '';
  }
  const values = Object.fromEntries(Object.entries(job.values).map(([name, value]) => [name, formatNumber(value)]));
  if (job.message === 'few_pictures') {
    return counted('job.end.few_pictures', job.values.pictures ?? 0, values);
  }
  const key = kEnds[job.message];
  if (key !== undefined) {
    return text(key, values);
  }
  return job.text === '' ? '' : text('job.end.says', { text: sentence(job.text) });
}

function sentence(words: string): string {
  const whole = words.charAt(0).toUpperCase() + words.slice(1);
  return /[.!?]$/.test(whole) ? whole : `${whole}.`;
}
