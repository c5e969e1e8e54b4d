// A frame as the computer takes it: "RWF1", the header's length (32 bits, little endian), the header as JSON, the
// colour image. Phones have no depth.

const kMagic = 'RWF1';

export function frameEnvelope(t: number, color: Uint8Array): Uint8Array<ArrayBuffer> {
  const header = new TextEncoder().encode(
    JSON.stringify({ t, color_bytes: color.byteLength, depth_bytes: 0 }),
  );
  const envelope = new Uint8Array(8 + header.byteLength + color.byteLength);
  envelope.set(new TextEncoder().encode(kMagic), 0);
  new DataView(envelope.buffer).setUint32(4, header.byteLength, true);
  envelope.set(header, 8);
  envelope.set(color, 8 + header.byteLength);
  return envelope;
}
