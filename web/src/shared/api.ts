// Requests to the home's computer. Whatever goes wrong is an ApiError whose message can be shown.
import { at } from './base';
import { counted, language, text, type TextKey } from './texts';

export class ApiError extends Error {
  constructor(
    readonly status: number, // 0: the computer was not reached
    message: string,
    readonly isEnglish = false, // the computer's own words, for which the pages have none
  ) {
    super(message);
  }
}

type Method = 'GET' | 'POST' | 'PUT' | 'DELETE';

export const kPatienceMs = 4000;

let silent = (): void => undefined;

// `run`: a request was given up, since the computer answers nothing any more.
export function whenSilent(run: () => void): void {
  silent = run;
}

async function send<Answer>(
  method: Method, path: string, body: object | Blob | undefined, read: (response: Response) => Promise<Answer>,
): Promise<Answer> {
  const givenUp = new AbortController();
  const init: RequestInit = { method, credentials: 'same-origin', cache: 'no-store', signal: givenUp.signal };
  if (body instanceof Blob) {
    init.body = body;
    init.headers = { 'Content-Type': body.type || 'application/octet-stream' };
  } else if (body) {
    init.body = JSON.stringify(body);
    init.headers = { 'Content-Type': 'application/json' };
  }
  const answered = watchForSilence(givenUp);
  let refusal: ApiError;
  try {
    const response = await fetch(at(path), init);
    if (response.ok) {
      return await read(response);
    }
    refusal = await refusalOf(response);
  } catch {
    throw new ApiError(0, text('error.not_reached'));
  } finally {
    answered();
  }
  throw refusal;
}

// Some work takes long. So a request is given up only where the computer does not answer the shortest one either. A network
// that is dead would else be noticed after minutes. To be called when the request is over.
function watchForSilence(givenUp: AbortController): () => void {
  let isOver = false;
  const look = async (): Promise<void> => {
    if (!(await isThere()) && !isOver) {
      givenUp.abort();
      silent();
    }
  };
  const timer = setInterval(() => void look(), kPatienceMs);
  return () => {
    isOver = true;
    clearInterval(timer);
  };
}

async function isThere(): Promise<boolean> {
  const late = new AbortController();
  const timer = setTimeout(() => late.abort(), kPatienceMs);
  try {
    await fetch(at('/health'), { cache: 'no-store', signal: late.signal });
    return true; // whatever it says
  } catch {
    return false;
  } finally {
    clearTimeout(timer);
  }
}

const kRefusals: Record<string, TextKey> = {
  code_over: 'error.code_over', link_over: 'error.link_over', many_requests: 'error.many_requests', not_paired: 'error.not_paired',
  not_for_role: 'error.not_for_role', later: 'error.later', fault: 'error.fault',
};

async function refusalOf(response: Response): Promise<ApiError> {
  const { status } = response;
  try {
    const { error, message } = (await response.json()) as { error?: unknown; message?: unknown };
    const key = kRefusals[String(message)];
    if (key !== undefined) {
      return new ApiError(status, text(key));
    }
    const seconds = Number(response.headers.get('Retry-After'));
    if (message === 'many_codes' && seconds > 0) {
      return new ApiError(status, counted('error.many_codes', seconds));
    }
    if (typeof error === 'string') {
      return new ApiError(status, error, true);
    }
  } catch {
    // No JSON: the status must do.
  }
  return new ApiError(status, text('error.status', { status }));
}

export async function request<Answer>(
  method: Method,
  path: string,
  body?: object | Blob,
): Promise<Answer> {
  const words = await send(method, path, body, (response) => response.text());
  return (words === '' ? {} : JSON.parse(words)) as Answer;
}

export function requestBytes(path: string): Promise<ArrayBuffer> {
  return send('GET', path, undefined, (response) => response.arrayBuffer());
}

export function messageOf(error: unknown): string {
  return error instanceof Error ? error.message : String(error);
}

// Shows what went wrong, in the language in which it is to be read.
export function showWhy(element: HTMLElement, error: unknown): void {
  if (error instanceof ApiError && error.isEnglish) {
    element.lang = 'en';
  } else {
    element.removeAttribute('lang');
  }
  element.textContent = messageOf(error);
}

// To be spoken: a voice speaks one language.
export function spokenFailure(error: unknown): string {
  const isForeign = error instanceof ApiError && error.isEnglish && language() !== 'en';
  return isForeign ? text('error.status', { status: error.status }) : messageOf(error);
}
