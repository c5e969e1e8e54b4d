// Hands a file to the computer in pieces, and goes on where it was stopped: what is there is asked first. A piece whose
// answer did not come is sent again. What sends is handed in, so tests need no network.
import { ApiError } from './api';

export interface UploadState {
  upload: string;
  name: string;
  bytes: number;
  offset: number; // bytes that are there
  chunk_bytes: number; // the most that a piece may have
  is_being_mapped?: boolean; // in the list of those that wait
}

export interface UploadParts {
  begin: (file: { name: string; bytes: number; modified: string }) => Promise<UploadState>;
  put: (upload: string, offset: number, piece: Blob) => Promise<UploadState>;
  wait: (ms: number) => Promise<void>;
}

export const kWaitsMs = [500, 1000, 2000, 4000, 8000] as const; // between tries without a connection

export class UploadStopped extends Error {}

// `told`: with each piece. Gives the upload, whole. Fails with the computer's refusal, with UploadStopped after `stop`, and
// never for want of a connection: that is waited for.
export async function handIn(
  file: File, parts: UploadParts, told: (state: UploadState, isWaiting: boolean) => void, stop: { asked: boolean },
): Promise<UploadState> {
  let state: UploadState | null = null;
  let tries = 0;
  for (;;) {
    if (stop.asked) {
      throw new UploadStopped();
    }
    try {
      state = state === null ? await parts.begin({ name: file.name, bytes: file.size, modified: String(file.lastModified) })
        : await parts.put(state.upload, state.offset, file.slice(state.offset, state.offset + state.chunk_bytes));
      tries = 0;
      told(state, false);
      if (state.offset >= state.bytes) {
        return state;
      }
    } catch (error) {
      if (!isPassing(error)) {
        throw error;
      }
      if (state) {
        told(state, true);
      }
      await parts.wait(kWaitsMs[Math.min(tries, kWaitsMs.length - 1)] ?? 0);
      tries += 1;
      state = null; // asks anew what is there
    }
  }
}

// No connection, or a computer that is busy.
function isPassing(error: unknown): boolean {
  return error instanceof ApiError && (error.status === 0 || error.status === 429 || error.status === 503);
}
