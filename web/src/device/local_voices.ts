// Voices that speak on the phone itself. Others are sent what they say, and that leaves the home: they are never used.
import type { Language } from '../shared/protocol';

const kKnownWithinMs = 2000; // some browsers tell their voices late, some tell of none

export function localVoice(language: Language): SpeechSynthesisVoice | null {
  const fitting = allVoices().filter((voice) => voice.localService && voice.lang.toLowerCase().startsWith(language));
  return fitting.find((voice) => voice.default) ?? fitting[0] ?? null;
}

// Whether there is one, as soon as that is known.
export function hasLocalVoice(language: Language): Promise<boolean> {
  return new Promise((resolve) => {
    if (!('speechSynthesis' in window) || localVoice(language)) {
      resolve(localVoice(language) !== null);
      return;
    }
    const over = (): void => {
      window.clearTimeout(timer);
      window.speechSynthesis.removeEventListener?.('voiceschanged', look);
      resolve(localVoice(language) !== null);
    };
    const look = (): void => {
      if (localVoice(language)) {
        over();
      }
    };
    const timer = window.setTimeout(over, kKnownWithinMs);
    window.speechSynthesis.addEventListener?.('voiceschanged', look); // Safari 15 tells of no changes: it is asked in the end
  });
}

function allVoices(): SpeechSynthesisVoice[] {
  return 'speechSynthesis' in window ? window.speechSynthesis.getVoices() : [];
}
