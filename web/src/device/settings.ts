// What the person chose on this phone; kept by the browser, never sent but for what `hello` names.
import { at } from '../shared/base';
import type { Distances } from '../shared/protocol';

export interface Settings {
  voice: 'own' | 'reader' | null; // null: not chosen yet
  rate: number; // of the own voice, 1 is the voice's normal
  distances: Distances;
  step_m: number;
  callouts: boolean;
  sounds: boolean;
  vibration: boolean;
  aim: boolean; // tone and vibration of the last metre
  mayWatch: boolean; // helpers, where this phone is and how somebody is led
}

export const kDefaults: Settings = {
  voice: null, rate: 1, distances: 'metres', step_m: 0.7, callouts: true, sounds: true, vibration: true, aim: true, mayWatch: false,
};
export const kRates = { least: 0.5, most: 3 };
export const kSteps = { least: 0.3, most: 1.2 };
const kStored = 'roomwise.settings';
const kPaired = `roomwise.paired${at('')}`; // of this home

export function loadSettings(storage: Storage): Settings {
  return settingsFrom(storage.getItem(kStored));
}

export function saveSettings(storage: Storage, settings: Settings): void {
  storage.setItem(kStored, JSON.stringify(settings));
}

// Whether this browser was paired when the computer was last asked.
export function wasPaired(storage: Storage): boolean {
  return storage.getItem(kPaired) !== null;
}

export function rememberPaired(storage: Storage, isPaired: boolean): void {
  if (isPaired) {
    storage.setItem(kPaired, 'yes');
  } else {
    storage.removeItem(kPaired);
  }
}

// What does not fit is taken from the defaults, member by member: an older page may have written it.
export function settingsFrom(stored: string | null): Settings {
  let found: Partial<Record<keyof Settings, unknown>> = {};
  try {
    found = (JSON.parse(stored ?? '{}') ?? {}) as typeof found;
  } catch {
    // Not JSON.
  }
  const flag = (name: 'callouts' | 'sounds' | 'vibration' | 'aim' | 'mayWatch'): boolean =>
    typeof found[name] === 'boolean' ? found[name] : kDefaults[name];
  return {
    voice: found.voice === 'own' || found.voice === 'reader' ? found.voice : kDefaults.voice,
    rate: within(found.rate, kRates, kDefaults.rate),
    distances: found.distances === 'steps' ? 'steps' : kDefaults.distances,
    step_m: within(found.step_m, kSteps, kDefaults.step_m),
    callouts: flag('callouts'),
    sounds: flag('sounds'),
    vibration: flag('vibration'),
    aim: flag('aim'),
    mayWatch: flag('mayWatch'),
  };
}

function within(value: unknown, limits: { least: number; most: number }, otherwise: number): number {
  return typeof value === 'number' && value >= limits.least && value <= limits.most ? value : otherwise;
}
