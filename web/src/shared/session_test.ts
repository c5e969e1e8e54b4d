import assert from 'node:assert/strict';
import { test } from 'node:test';

import type { FromComputer, Hello } from './protocol';
import { kWaitsMs, kWelcomeWithinMs, Session, type Socket } from './session';

class FakeSocket implements Socket {
  onopen: (() => void) | null = null;
  onmessage: ((event: { data: unknown }) => void) | null = null;
  onclose: (() => void) | null = null;
  sent: string[] = [];
  send(data: string | Uint8Array<ArrayBuffer>): void {
    this.sent.push(typeof data === 'string' ? data : 'bytes');
  }
  close(): void {
    this.onclose?.();
  }
}

const kHello: Hello = {
  type: 'hello', version: 1, name: 'phone', kind: 'phone', camera: null,
  language: 'en', distances: 'metres', step_m: 0.7, callouts: true, may_watch: false,
};

function makeSession() {
  const world = {
    sockets: [] as FakeSocket[],
    timers: [] as { run: () => void; ms: number }[],
    messages: [] as FromComputer[],
    states: [] as string[],
  };
  const session = new Session({
    openSocket: () => {
      const socket = new FakeSocket();
      world.sockets.push(socket);
      return socket;
    },
    hello: () => kHello,
    onMessage: (message) => world.messages.push(message),
    onOnline: () => world.states.push('online'),
    onOffline: () => world.states.push('offline'),
    setTimer: (run, ms) => world.timers.push({ run, ms }) - 1,
    clearTimer: (timer) => {
      world.timers[timer] = { run: () => assert.fail('a cleared timer ran'), ms: -1 };
    },
  });
  const newest = (): FakeSocket => world.sockets[world.sockets.length - 1] as FakeSocket;
  const lastTimer = () => world.timers[world.timers.length - 1] as { run: () => void; ms: number };
  const welcome = (): void => newest().onmessage?.({ data: '{"type":"welcome","home":"flat"}' });
  return { session, world, newest, lastTimer, welcome };
}

test('hello is said first, and the session is online after welcome', () => {
  const { session, world, newest, welcome } = makeSession();
  session.connect();
  assert.equal(session.send({ type: 'quiet', on: true }), false);
  newest().onopen?.();
  assert.deepEqual(newest().sent, [JSON.stringify(kHello)]);
  assert.equal(session.online, false);
  welcome();
  assert.equal(session.online, true);
  assert.deepEqual(world.states, ['online']);
  assert.equal(world.messages[0]?.type, 'welcome');
});

test('waits between tries grow, stay at the longest, and begin anew after a welcome', () => {
  const { session, newest, lastTimer, welcome } = makeSession();
  session.connect();
  const waits: number[] = [];
  for (let attempt = 0; attempt < 8; attempt += 1) {
    newest().close();
    waits.push(lastTimer().ms);
    lastTimer().run();
  }
  assert.deepEqual(waits, [...kWaitsMs, 8000, 8000]);
  welcome();
  newest().close();
  assert.equal(lastTimer().ms, kWaitsMs[0]);
});

test('a computer that does not welcome is given up', () => {
  const { session, world, newest, lastTimer } = makeSession();
  session.connect();
  newest().onopen?.();
  assert.equal(lastTimer().ms, kWelcomeWithinMs);
  lastTimer().run();
  assert.deepEqual(world.states, ['offline']);
  assert.equal(lastTimer().ms, kWaitsMs[0]);
});

test('nothing that an old connection still says is heard', () => {
  const { session, world, newest, lastTimer, welcome } = makeSession();
  session.connect();
  welcome();
  const old = newest();
  const handler = old.onmessage;
  session.reconnect();
  lastTimer().run();
  assert.equal(world.sockets.length, 2);
  handler?.({ data: '{"type":"frame","t":1,"dropped":0}' });
  assert.equal(world.messages.length, 1);
});

test('questions are numbered, and there is no number without a connection', () => {
  const { session, newest, welcome } = makeSession();
  session.connect();
  assert.equal(session.ask({ question: 'where_am_i' }, 5), null);
  welcome();
  const id = session.ask({ question: 'where_is', thing: 'bed' }, 6);
  assert.deepEqual(JSON.parse(newest().sent[0] ?? ''), {
    type: 'ask', id, t: 6, question: 'where_is', thing: 'bed',
  });
});
