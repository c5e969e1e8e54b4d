// Reads an export by packages of npm that others made for its format, and prints what they found as JSON:
// read_by_packages.mjs json|mcap|glb FILE. They lie in web/node_modules.
import { readFileSync } from 'node:fs';
import { createRequire } from 'node:module';

const repository = new URL('../../', import.meta.url);
const require = createRequire(new URL('web/package.json', repository));
const Ajv = require('ajv/dist/2020').default;

function parsed(file) {
  return JSON.parse(readFileSync(file, 'utf8'));
}
function violations(check, value) {
  return check(value) ? [] : check.errors.map(({ instancePath, message }) => `${instancePath} ${message}`);
}

// The home's plain JSON by its schema.
function readHome(file) {
  const ajv = new Ajv({ strict: true, allErrors: true });
  return { violations: violations(ajv.compile(parsed(new URL('docs/home.schema.json', repository))), parsed(file)) };
}

// A walk by its index, in the order of time, each message by the schema that Foxglove publishes; and once more as a stream.
async function readMcap(file) {
  const { McapIndexedReader, McapStreamReader } = require('@mcap/core');
  const { foxgloveMessageSchemas, generateJsonSchema } = require('@foxglove/schemas/internal.js');
  const ajv = new Ajv({ strict: false, allErrors: true });
  const checks = new Map(Object.values(foxgloveMessageSchemas).map((one) => [`foxglove.${one.name}`, ajv.compile(generateJsonSchema(one))]));
  const data = readFileSync(file);
  const reader = await McapIndexedReader.Initialize({
    readable: { size: async () => BigInt(data.length), read: async (at, size) => data.subarray(Number(at), Number(at + size)) },
  });
  const found = { topics: {}, violations: [], in_order: true, streamed: 0 };
  let last = 0n;
  for await (const message of reader.readMessages({ validateCrcs: true })) {
    const { topic, schemaId } = reader.channelsById.get(message.channelId);
    const schema = reader.schemasById.get(schemaId).name;
    found.topics[topic] = (found.topics[topic] ?? 0) + 1;
    found.violations.push(...violations(checks.get(schema), JSON.parse(Buffer.from(message.data).toString())).map((one) => `${topic}: ${one}`));
    found.in_order &&= message.logTime >= last;
    last = message.logTime;
  }
  const stream = new McapStreamReader({ validateCrcs: true });
  stream.append(data);
  for (let record = stream.nextRecord(); record !== undefined; record = stream.nextRecord()) {
    found.streamed += record.type === 'Message' ? 1 : 0;
  }
  return { ...found, ended: stream.done() };
}

// The surface by Khronos' validator.
async function readGlb(file) {
  const { issues, info } = await require('gltf-validator').validateBytes(new Uint8Array(readFileSync(file)));
  return { violations: issues.messages.map(({ message }) => message), triangles: info.totalTriangleCount };
}

const [kind, file] = process.argv.slice(2);
console.log(JSON.stringify(await { json: readHome, mcap: readMcap, glb: readGlb }[kind](file)));
