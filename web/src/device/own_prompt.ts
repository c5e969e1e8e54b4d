// Prompts that the phone makes itself.
import type { Priority, Sound } from '../shared/protocol';
import type { SpokenKey } from '../shared/spoken';
import { language, spokenText } from '../shared/texts';
import type { QueuedPrompt } from './prompt_queue';

const kSounds: Partial<Record<SpokenKey, Sound>> = {
  'device.camera_dark': 'alert',
  'device.camera_covered': 'alert',
  'device.camera_blurred': 'alert',
  'device.camera_refused': 'alert',
  'device.camera_failed': 'alert',
  'device.camera_back': 'back',
  'device.connecting': 'none',
  'device.connection_lost': 'lost',
  'device.connection_lost_led': 'lost',
  'device.connection_back': 'back',
  'device.removed': 'alert',
  'device.failed': 'unsure',
  'device.one_moment': 'none',
  'device.recording_empty': 'alert',
  'device.recording_failed': 'alert',
};
const kValidMs = 10_000;

export function ownPrompt(key: SpokenKey, now: number, priority: Priority = 'notice'): QueuedPrompt {
  const sound = kSounds[key] ?? 'answer';
  // News of the connection replace older ones, and so on.
  return { ...ownNotice(key.split('_')[0] ?? key, spokenText(key), now), priority, sound, message: key };
}

export function ownNotice(key: string, text: string, now: number): QueuedPrompt {
  return { key, text, language: language(), priority: 'notice', sound: 'alert', valid_until_t: now + kValidMs };
}
