// Stands in for `roomwise serve` in tests of the pages: serves them with the same Content-Security-Policy, and speaks
// docs/protocol.md about a made-up home. What it is told and asked can be looked at; tests say what happens when.
import { readFile } from 'node:fs/promises';
import { createServer, type IncomingMessage, type Server, type ServerResponse } from 'node:http';
import type { AddressInfo } from 'node:net';
import { extname, join, normalize } from 'node:path';
import { WebSocketServer, type WebSocket } from 'ws';

import { kSubprotocol, type FrameAdditions, type Hello, type Prompt, type Role } from '../src/shared/protocol';
import { answerApi } from './stand_in_api';
import { StandInState } from './stand_in_state';

export const kPolicy =
  "default-src 'none'; script-src 'self'; style-src 'self'; img-src 'self' blob: data:; connect-src 'self'; " +
  "manifest-src 'self'; worker-src 'self'; media-src 'self' blob:; frame-ancestors 'none'; base-uri 'none'; " +
  "form-action 'none'";
const kTypes: Record<string, string> = {
  '.html': 'text/html; charset=utf-8', '.js': 'text/javascript; charset=utf-8', '.css': 'text/css; charset=utf-8',
  '.svg': 'image/svg+xml', '.png': 'image/png', '.webmanifest': 'application/manifest+json', '.txt': 'text/plain',
};
const kPages: Record<string, string> = { '/': '/index.html', '/device': '/device.html', '/pair': '/pair.html', '/staff': '/staff.html' };

export interface FrameHeader extends Partial<FrameAdditions> {
  t: number;
  color_bytes: number;
  depth_bytes: number;
}

export interface Client {
  socket: WebSocket;
  role: Role;
  hello: Hello | null;
  frames: number;
  newest: { header: FrameHeader; color: Buffer; depth: Buffer } | null; // frame
  asked: Record<string, unknown>[];
  told: Record<string, unknown>[]; // everything but frames, hello and questions
}

export class StandInServer {
  readonly state = new StandInState();
  readonly clients: Client[] = [];
  acknowledges = true;
  answersQuestions = true;
  before = ''; // a script that every page runs before its own
  silent = false; // as when the network is dead: connections stay, and nothing comes any more
  private server: Server | null = null;
  private port = 0;

  constructor(private readonly pages: string) {}

  get url(): string {
    return `http://localhost:${this.port}`;
  }

  // At the same address as before, where it was there before.
  async start(port = this.port): Promise<void> {
    const server = createServer((request, response) => void this.handle(request, response));
    const sockets = new WebSocketServer({ noServer: true, handleProtocols: () => kSubprotocol });
    server.on('upgrade', (request, stream, head) => {
      const role = this.roleOf(request);
      if (!role || request.url !== '/api/socket') {
        stream.end('HTTP/1.1 401 Unauthorized\r\n\r\n');
        return;
      }
      sockets.handleUpgrade(request, stream, head, (socket) => this.connected(socket, role));
    });
    await new Promise<void>((resolve) => server.listen(port, 'localhost', resolve));
    this.port = (server.address() as AddressInfo).port;
    this.server = server;
  }

  // As when the computer is switched off.
  async stop(): Promise<void> {
    const server = this.server;
    this.server = null;
    this.clients.splice(0).forEach(({ socket }) => socket.terminate());
    server?.closeAllConnections();
    await new Promise<void>((resolve) => (server ? server.close(() => resolve()) : resolve()));
  }

  newest(role: Role): Client {
    const found = this.clients.filter((client) => client.role === role && client.hello).pop();
    if (!found) {
      throw new Error(`no ${role} is connected`);
    }
    return found;
  }

  tell(role: Role, message: object): void {
    for (const client of this.clients.filter((one) => one.role === role)) {
      client.socket.send(JSON.stringify(message));
    }
  }

  private connected(socket: WebSocket, role: Role): void {
    const client: Client = { socket, role, hello: null, frames: 0, newest: null, asked: [], told: [] };
    this.clients.push(client);
    socket.on('close', () => {
      const at = this.clients.indexOf(client);
      if (at >= 0) {
        this.clients.splice(at, 1);
      }
    });
    socket.on('message', (data, isBinary) => {
      if (this.silent) {
        return;
      }
      const bytes = data as Buffer;
      if (isBinary) {
        this.takeFrame(client, bytes);
      } else {
        this.takeMessage(client, JSON.parse(bytes.toString()) as Record<string, unknown>);
      }
    });
  }

  private takeFrame(client: Client, bytes: Buffer): void {
    if (bytes.subarray(0, 4).toString() !== 'RWF1') {
      throw new Error('a frame without RWF1');
    }
    const length = bytes.readUInt32LE(4);
    const header = JSON.parse(bytes.subarray(8, 8 + length).toString()) as FrameHeader;
    if (header.color_bytes + header.depth_bytes !== bytes.length - 8 - length || bytes.readUInt16BE(8 + length) !== 0xffd8) {
      throw new Error('a frame that is not what its header says');
    }
    client.frames += 1;
    client.newest = { header, color: bytes.subarray(8 + length, 8 + length + header.color_bytes), depth: bytes.subarray(8 + length + header.color_bytes) };
    if (this.acknowledges) {
      client.socket.send(JSON.stringify({ type: 'frame', t: header.t, dropped: 0 }));
    }
  }

  private takeMessage(client: Client, message: Record<string, unknown>): void {
    if (message['type'] === 'hello') {
      client.hello = message as unknown as Hello;
      client.socket.send(JSON.stringify(this.state.welcome(client.role)));
      this.state.recordedFor(client.role).forEach((message) => client.socket.send(JSON.stringify(message)));
    } else if (message['type'] === 'ask') {
      client.asked.push(message);
      if (this.answersQuestions) {
        client.socket.send(JSON.stringify(answerTo(message)));
      }
    } else {
      client.told.push(message);
    }
  }

  private roleOf(request: IncomingMessage): Role | null {
    const token = /(?:^|; )roomwise=([^;]+)/.exec(request.headers.cookie ?? '')?.[1];
    return this.state.roleOf(token);
  }

  private withScriptBefore(file: string, bytes: Buffer): Buffer {
    return this.before === '' || extname(file) !== '.html' ? bytes
      : Buffer.from(bytes.toString().replace('<head>', '<head><script src="/before.js"></script>'));
  }

  private async handle(request: IncomingMessage, response: ServerResponse): Promise<void> {
    if (this.silent) {
      return;
    }
    const path = (request.url ?? '/').split('?')[0] ?? '/';
    if (path.startsWith('/api/') || path === '/health') {
      const chunks: Buffer[] = [];
      for await (const chunk of request) {
        chunks.push(chunk as Buffer);
      }
      const body = Buffer.concat(chunks);
      answerApi(this, request.method ?? 'GET', decodeURIComponent(path), body, this.roleOf(request), response);
      return;
    }
    try {
      const file = kPages[path] ?? normalize(path);
      const bytes = path === '/before.js' ? Buffer.from(this.before) : this.withScriptBefore(file, await readFile(join(this.pages, file)));
      response.writeHead(200, {
        'Content-Type': kTypes[extname(file)] ?? 'application/octet-stream',
        'Content-Security-Policy': kPolicy, 'X-Content-Type-Options': 'nosniff', 'Cache-Control': 'no-cache',
      });
      response.end(bytes);
    } catch {
      response.writeHead(404).end();
    }
  }
}

export function makePrompt(more: Partial<Prompt>): Prompt {
  return {
    type: 'prompt', answer_to: null, key: 'room', message: 'room.is', text: 'You are in the kitchen.', language: 'en',
    priority: 'answer', confidence: 'sure', sound: 'answer', because: '', based_on_t: null, valid_until_t: 1e12, ...more,
  };
}

const kBegins = { key: 'guide', message: 'guide.begin' };

function answerTo(message: Record<string, unknown>): Prompt {
  const answer_to = Number(message['id']);
  switch (message['question']) {
    case 'where_is':
      return makePrompt({
        answer_to, key: 'thing', message: 'thing.is',
        text: `The ${String(message['thing'])} is two metres before you, a little to the left.`,
      });
    case 'around_me':
      return makePrompt({ answer_to, key: 'around', text: 'Before you the dining table, to the right the stove.' });
    case 'in_words':
      return makePrompt({
        answer_to, ...(/take me/i.test(String(message['text'])) ? kBegins : { key: 'asked', message: 'asked' }),
        text: `You asked: ${String(message['text'])}.`,
      });
    case 'take_me_to':
    case 'take_me_back':
      return makePrompt({ answer_to, ...kBegins, text: 'Turn right, then three metres straight on.' });
    case 'mark_spot':
      return makePrompt({ answer_to, key: 'spot', message: 'spot.marked', text: `${String(message['spot'] ?? 'This place')} is marked here.` });
    case 'hide_walks':
      return makePrompt({ answer_to, key: 'watch', message: 'watch.hidden', text: 'Nobody watches your walks.' });
    case 'name_room':
      return makePrompt({ answer_to, key: 'named', text: `This room is called ${String(message['room'])} now.` });
    default:
      return makePrompt({ answer_to });
  }
}
