// Requests to the home's computer. Whatever goes wrong is an ApiError whose message can be shown.
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

async function send(method: Method, path: string, body?: object | Blob): Promise<Response> {
  const init: RequestInit = { method, credentials: 'same-origin', cache: 'no-store' };
  if (body instanceof Blob) {
    init.body = body;
    init.headers = { 'Content-Type': body.type || 'application/octet-stream' };
  } else if (body) {
    init.body = JSON.stringify(body);
    init.headers = { 'Content-Type': 'application/json' };
  }
  let response: Response;
  try {
    response = await fetch(path, init);
  } catch {
    throw new ApiError(0, text('error.not_reached'));
  }
  if (!response.ok) {
    throw new ApiError(response.status, await reason(response));
  }
  return response;
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
  const response = await send(method, path, body);
  const words = await response.text();
  return (words === '' ? {} : JSON.parse(words)) as Answer;
}

export async function requestBytes(path: string): Promise<ArrayBuffer> {
  return (await send('GET', path)).arrayBuffer();
}

export function messageOf(error: unknown): string {
  return error instanceof Error ? error.message : String(error);
}
