import assert from 'node:assert/strict';
import { test } from 'node:test';
import * as zlib from 'node:zlib';

import { encodePng16 } from './png16';

const kCrc32 = (zlib as { crc32?: (bytes: Uint8Array) => number }).crc32; // of newer versions of Node.js

test('a grey image of 16 bits is a PNG with all its chunks', async () => {
  const png = Buffer.from(await encodePng16(2, 3, Uint16Array.of(1, 65_535, 300, 0, 7, 8)));
  assert.equal(png.subarray(0, 8).toString('latin1'), '\x89PNG\r\n\x1a\n');
  const chunks = new Map<string, Buffer>();
  for (let at = 8; at < png.length;) {
    const length = png.readUInt32BE(at);
    const kind = png.subarray(at + 4, at + 8).toString();
    chunks.set(kind, png.subarray(at + 8, at + 8 + length));
    if (kCrc32) {
      assert.equal(png.readUInt32BE(at + 8 + length), kCrc32(png.subarray(at + 4, at + 8 + length)), kind);
    }
    at += 12 + length;
  }
  assert.deepEqual([...chunks.keys()], ['IHDR', 'IDAT', 'IEND']);
  assert.deepEqual([...(chunks.get('IHDR') ?? [])], [0, 0, 0, 2, 0, 0, 0, 3, 16, 0, 0, 0, 0]);
  assert.deepEqual([...zlib.inflateSync(chunks.get('IDAT') ?? Buffer.alloc(0))], [
    0, 0, 1, 255, 255,
    0, 1, 44, 0, 0,
    0, 0, 7, 0, 8,
  ]);
});
