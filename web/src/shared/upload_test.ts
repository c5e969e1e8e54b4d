import assert from 'node:assert/strict';
import { test } from 'node:test';

import { ApiError } from './api';
import { handIn, UploadStopped, type UploadParts, type UploadState } from './upload';

// A computer that takes pieces of four bytes.
class Computer implements UploadParts {
  there = '';
  begun = 0;
  waits: number[] = [];
  sent: [number, string][] = [];
  fails: (ApiError | null)[] = []; // of the next pieces; the bytes come all the same where `arrives`
  arrives = false;

  constructor(private readonly bytes: number) {}

  state(): UploadState {
    return { upload: 'u', name: 'scan.zip', bytes: this.bytes, offset: this.there.length, chunk_bytes: 4 };
  }

  begin = async (): Promise<UploadState> => {
    this.begun += 1;
    return this.state();
  };

  put = async (_upload: string, offset: number, piece: Blob): Promise<UploadState> => {
    const words = await piece.text();
    this.sent.push([offset, words]);
    const failure = this.fails.shift() ?? null;
    if (!failure || this.arrives) {
      this.there += words.slice(this.there.length - offset);
    }
    if (failure) {
      throw failure;
    }
    return this.state();
  };

  wait = async (ms: number): Promise<void> => void this.waits.push(ms);
}

function fileOf(words: string): File {
  return Object.assign(new Blob([words]), { name: 'scan.zip', lastModified: 7 }) as unknown as File;
}

test('a file goes in pieces, and each is told', async () => {
  const computer = new Computer(10);
  const told: number[] = [];
  await handIn(fileOf('0123456789'), computer, ({ offset }) => told.push(offset), { asked: false });
  assert.equal(computer.there, '0123456789');
  assert.deepEqual(told, [0, 4, 8, 10]);
});

test('what is there already is not sent again', async () => {
  const computer = new Computer(10);
  computer.there = '01234567';
  await handIn(fileOf('0123456789'), computer, () => undefined, { asked: false });
  assert.deepEqual(computer.sent, [[8, '89']]);
});

test('a connection that is lost is waited for; where to go on is asked anew', async () => {
  for (const arrives of [false, true]) {
    const computer = new Computer(8);
    computer.arrives = arrives; // the piece came, its answer did not
    computer.fails = [null, new ApiError(0, ''), new ApiError(503, '')];
    const waiting: boolean[] = [];
    await handIn(fileOf('01234567'), computer, (_, isWaiting) => waiting.push(isWaiting), { asked: false });
    assert.equal(computer.there, '01234567');
    assert.ok(waiting.includes(true));
    assert.equal(computer.begun, 1 + computer.waits.length);
  }
});

test('a refusal ends it, and so does who stops it', async () => {
  const computer = new Computer(8);
  computer.fails = [new ApiError(409, 'the disk is full')];
  await assert.rejects(handIn(fileOf('01234567'), computer, () => undefined, { asked: false }), /the disk is full/);
  await assert.rejects(handIn(fileOf('01234567'), computer, () => undefined, { asked: true }), UploadStopped);
});
