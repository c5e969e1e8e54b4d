// Hears a question by the browser's own recogniser, where that works on the phone itself. Elsewhere it sends what is said to
// whoever made the browser, and that leaves the home: it is never used then.

export type HearingFailure = 'refused' | 'nothing';

interface Recognition extends EventTarget {
  lang: string;
  processLocally: boolean;
  start: () => void;
  abort: () => void;
}

interface RecognitionKind {
  new (): Recognition;
  available?: (options: { langs: string[]; processLocally: boolean }) => Promise<string>;
}

type ResultEvent = Event & { results: ArrayLike<ArrayLike<{ transcript: string }>> };
type ErrorEvent = Event & { error: string };

const kRegions: Record<string, string> = { en: 'en-US', de: 'de-DE', es: 'es-ES', fr: 'fr-FR' };

// The way to hear this language on the phone itself, or null where there is none, or none that says so.
export async function localHearing(language: string, preferred: readonly string[]): Promise<LocalHearing | null> {
  const kind = recognitionKind();
  if (!kind?.available || !('processLocally' in kind.prototype)) {
    return null;
  }
  const tag = tagOf(language, preferred);
  try {
    const state = await kind.available({ langs: [tag], processLocally: true });
    return state === 'available' ? new LocalHearing(kind, tag) : null;
  } catch {
    return null; // by the browser's policy
  }
}

// 'de' and ['en-GB', 'de-AT'] -> 'de-AT': recognisers want a region.
export function tagOf(language: string, preferred: readonly string[]): string {
  return preferred.find((tag) => tag.toLowerCase().startsWith(`${language}-`)) ?? kRegions[language] ?? language;
}

export class LocalHearing {
  private now: Recognition | null = null; // while it listens

  constructor(private readonly kind: RecognitionKind, private readonly tag: string) {}

  get listens(): boolean {
    return this.now !== null;
  }

  // Listens for one question.
  begin(heard: (text: string) => void, failed: (why: HearingFailure) => void, ended: () => void): void {
    this.stop();
    const recognition = new this.kind();
    recognition.lang = this.tag;
    recognition.processLocally = true; // refuses rather than to send what is said
    let isTold = false;
    const fail = (why: HearingFailure): void => {
      if (!isTold && this.now === recognition) {
        isTold = true;
        failed(why);
      }
    };
    recognition.addEventListener('result', (event) => {
      const text = (event as ResultEvent).results[0]?.[0]?.transcript.trim() ?? '';
      if (text !== '' && !isTold && this.now === recognition) {
        isTold = true;
        heard(text);
      }
    });
    recognition.addEventListener('error', (event) => {
      const { error } = event as ErrorEvent;
      fail(error === 'not-allowed' || error === 'service-not-allowed' || error === 'audio-capture' ? 'refused' : 'nothing');
    });
    recognition.addEventListener('end', () => {
      fail('nothing');
      if (this.now === recognition) {
        this.now = null;
        ended();
      }
    });
    this.now = recognition;
    try {
      recognition.start();
    } catch { // it is busy, or the browser forbids it just now
      fail('nothing');
      this.now = null;
      ended();
    }
  }

  // Without a word.
  stop(): void {
    const { now } = this;
    this.now = null;
    now?.abort();
  }
}

function recognitionKind(): RecognitionKind | undefined {
  const world = globalThis as unknown as { SpeechRecognition?: RecognitionKind; webkitSpeechRecognition?: RecognitionKind };
  return world.SpeechRecognition ?? world.webkitSpeechRecognition;
}
