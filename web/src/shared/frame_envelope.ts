// A frame as the computer takes it: "RWF1", the header's length (32 bits, little endian), the header as JSON, the
// colour image, the depth image.
import type { FrameAdditions } from './protocol';

const kMagic = 'RWF1';

export interface FrameParts {
  color: Uint8Array;
  depth?: Uint8Array;
  more?: FrameAdditions; // of version 2 of the header
}

export function frameEnvelope(t: number, { color, depth, more }: FrameParts): Uint8Array<ArrayBuffer> {
  const depthBytes = depth?.byteLength ?? 0;
  const header = new TextEncoder().encode(
    JSON.stringify({ t, color_bytes: color.byteLength, depth_bytes: depthBytes, ...more }),
  );
  const envelope = new Uint8Array(8 + header.byteLength + color.byteLength + depthBytes);
  envelope.set(new TextEncoder().encode(kMagic), 0);
  new DataView(envelope.buffer).setUint32(4, header.byteLength, true);
  envelope.set(header, 8);
  envelope.set(color, 8 + header.byteLength);
  if (depth) {
    envelope.set(depth, 8 + header.byteLength + color.byteLength);
  }
  return envelope;
}
