// The socket to the home's computer: says hello, hands on messages, and connects anew by itself with growing waits
// when the connection is gone. The socket and the timers are handed in, so tests need neither.
import type { FromComputer, Hello, Question } from './protocol';

export interface Socket {
  onopen: (() => void) | null;
  onmessage: ((event: { data: unknown }) => void) | null;
  onclose: (() => void) | null;
  send(data: string | Uint8Array<ArrayBuffer>): void;
  close(): void;
}

export interface SessionParts {
  openSocket: () => Socket;
  hello: () => Hello;
  onMessage: (message: FromComputer) => void;
  onOnline: () => void; // welcome has come
  onOffline: () => void; // a connection, or a try, is over
  setTimer: (run: () => void, ms: number) => number;
  clearTimer: (timer: number) => void;
}

export const kWaitsMs = [250, 500, 1000, 2000, 4000, 8000] as const;
export const kWelcomeWithinMs = 4000;

export class Session {
  private socket: Socket | null = null;
  private welcomed = false;
  private tries = 0;
  private timer: number | null = null;
  private lastId = 0;
  private over = false;

  constructor(private readonly parts: SessionParts) {}

  get online(): boolean {
    return this.welcomed;
  }

  // Connects now, also where a wait is under way.
  connect(): void {
    if (this.socket || this.over) {
      return;
    }
    this.stopTimer();
    const socket = this.parts.openSocket();
    this.socket = socket;
    socket.onopen = () => socket.send(JSON.stringify(this.parts.hello()));
    socket.onmessage = (event) => this.receive(socket, event.data);
    socket.onclose = () => this.closed(socket);
    this.timer = this.parts.setTimer(() => this.reconnect(), kWelcomeWithinMs);
  }

  // Gives this connection up and begins another: it is broken, or what hello said has changed.
  reconnect(): void {
    const socket = this.socket;
    if (!socket) {
      this.connect();
      return;
    }
    socket.onopen = socket.onmessage = socket.onclose = null;
    socket.close();
    this.closed(socket);
  }

  close(): void {
    this.over = true;
    this.stopTimer();
    this.socket?.close();
  }

  send(message: object): boolean {
    if (!this.socket || !this.welcomed) {
      return false;
    }
    this.socket.send(JSON.stringify(message));
    return true;
  }

  sendFrame(envelope: Uint8Array<ArrayBuffer>): boolean {
    if (!this.socket || !this.welcomed) {
      return false;
    }
    this.socket.send(envelope);
    return true;
  }

  // The number of the question, or null where there is no connection.
  ask(question: Question, t: number): number | null {
    this.lastId += 1;
    return this.send({ type: 'ask', id: this.lastId, t, ...question }) ? this.lastId : null;
  }

  private receive(socket: Socket, data: unknown): void {
    if (socket !== this.socket || typeof data !== 'string') {
      return;
    }
    const message = JSON.parse(data) as FromComputer;
    if (message.type === 'welcome') {
      this.welcomed = true;
      this.tries = 0;
      this.stopTimer();
      this.parts.onMessage(message);
      this.parts.onOnline();
    } else {
      this.parts.onMessage(message);
    }
  }

  private closed(socket: Socket): void {
    if (socket !== this.socket) {
      return;
    }
    this.socket = null;
    this.welcomed = false;
    this.stopTimer();
    this.parts.onOffline();
    if (!this.over) {
      const wait = kWaitsMs[Math.min(this.tries, kWaitsMs.length - 1)] ?? 0;
      this.tries += 1;
      this.timer = this.parts.setTimer(() => this.connect(), wait);
    }
  }

  private stopTimer(): void {
    if (this.timer !== null) {
      this.parts.clearTimer(this.timer);
      this.timer = null;
    }
  }
}
