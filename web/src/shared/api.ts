// Requests to the home's computer. Whatever goes wrong is an ApiError whose message can be shown.
import { at } from './base';
import { text } from './texts';

export class ApiError extends Error {
  constructor(
    readonly status: number, // 0: the computer was not reached
    message: string,
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
    refusal = new ApiError(response.status, await reason(response));
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

async function reason(response: Response): Promise<string> {
  try {
    const body = (await response.json()) as { error?: unknown };
    if (typeof body.error === 'string') {
      return body.error;
    }
  } catch {
    // No JSON: the status must do.
  }
  return text('error.status', { status: response.status });
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
