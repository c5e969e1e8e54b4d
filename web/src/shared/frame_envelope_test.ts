import assert from 'node:assert/strict';
import { test } from 'node:test';

import { frameEnvelope } from './frame_envelope';

test('an envelope holds magic, header length, header and picture, in this order', () => {
  const envelope = frameEnvelope(1234.5, { color: Uint8Array.of(7, 8, 9) });
  assert.equal(new TextDecoder().decode(envelope.subarray(0, 4)), 'RWF1');
  const length = new DataView(envelope.buffer).getUint32(4, true);
  const header: unknown = JSON.parse(new TextDecoder().decode(envelope.subarray(8, 8 + length)));
  assert.deepEqual(header, { t: 1234.5, color_bytes: 3, depth_bytes: 0 });
  assert.deepEqual([...envelope.subarray(8 + length)], [7, 8, 9]);
});

test('depth comes after the picture, and what version 2 adds stands in the header', () => {
  const more = { version: 2 as const, camera: null, depth: { width: 2, height: 1 }, pose: null };
  const envelope = frameEnvelope(1, { color: Uint8Array.of(7), depth: Uint8Array.of(1, 2), more });
  const length = new DataView(envelope.buffer).getUint32(4, true);
  const header: unknown = JSON.parse(new TextDecoder().decode(envelope.subarray(8, 8 + length)));
  assert.deepEqual(header, { t: 1, color_bytes: 1, depth_bytes: 2, ...more });
  assert.deepEqual([...envelope.subarray(8 + length)], [7, 1, 2]);
});
