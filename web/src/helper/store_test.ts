import assert from 'node:assert/strict';
import { test, type TestContext } from 'node:test';

import type { Job, WatchedDevice } from '../shared/protocol';
import { HelperStore } from './store';

test('a listener that throws does not keep the news from the others', (context) => {
  const told = context.mock.method(console, 'error', () => undefined);
  const store = new HelperStore();
  const heard: string[] = [];
  store.watch(['online'], () => {
    if (store.state.online) {
      throw new Error('this part cannot be shown');
    }
  });
  store.watch(['online'], () => heard.push(`online: ${store.state.online}`));
  store.setOnline(true);
  assert.deepEqual(heard, ['online: false', 'online: true']);
  assert.equal(told.mock.callCount(), 1, 'it is not swallowed');
});

// What was asked for, to be answered in any order.
function heldAnswers(context: TestContext): { path: string; answer: (body: unknown) => void }[] {
  const asked: { path: string; answer: (body: unknown) => void }[] = [];
  context.mock.method(globalThis, 'fetch', (path: string) => new Promise<Response>((resolve) => {
    asked.push({ path, answer: (body) => resolve(Response.json(body)) });
  }));
  return asked;
}

const prepare = (state: 'running' | 'done'): Job =>
  ({ type: 'job', kind: 'prepare', state, stage: '', fraction: 0, text: '' }) as unknown as Job;

test('an answer that comes after the socket told that a job has ended does not bring it back', async (context) => {
  const asked = heldAnswers(context);
  const store = new HelperStore();
  const refreshed = store.refreshJob();
  store.receive(prepare('done'));
  asked[0]?.answer(prepare('running'));
  asked.slice(1).forEach(({ answer }) => answer({})); // about the home, since a job has ended
  await refreshed;
  assert.equal(store.state.job?.state, 'done');
});

test('of two answers about the home the one that was asked for later holds', async (context) => {
  const asked = heldAnswers(context);
  const store = new HelperStore();
  const answerAll = (of: typeof asked, name: string): void => of.forEach(({ path, answer }) => {
    answer(path === '/api/home' ? { name } : path === '/api/edits' ? { edits: [] } : { keyframes: [] });
  });
  const older = store.refreshHome();
  const newer = store.refreshHome();
  answerAll(asked.slice(asked.length / 2), 'new');
  await newer;
  answerAll(asked.slice(0, asked.length / 2), 'old');
  await older;
  assert.equal(store.state.home?.name, 'new');
});

const led = (t: number, state: 'on_way' | 'lost' | null, device = 3): WatchedDevice => ({
  type: 'led_walk', device, name: 'phone', t, may_watch: state !== null,
  walk: state === null ? null : { language: 'en', goal: 'bed', state, person: null, left_m: null, way: [], said: [] },
});

test('of how somebody is led an older message changes nothing, and each device is told of by itself', () => {
  const store = new HelperStore();
  let told = 0;
  store.watch(['watched'], () => (told += 1));
  store.receive(led(20, 'lost'));
  store.receive(led(10, 'on_way'));
  assert.equal(store.state.watched.get(3)?.walk?.state, 'lost');
  store.receive(led(15, 'on_way', 4));
  assert.equal(store.state.watched.get(4)?.walk?.state, 'on_way');
  assert.equal(told, 3, 'once at first');
  store.receive(led(21, null));
  assert.equal(store.state.watched.get(3)?.walk, null, 'they do not let helpers watch any more');
  store.receive(led(20.5, 'on_way'));
  assert.equal(store.state.watched.get(3)?.walk, null);
  store.forgetWatched();
  assert.equal(store.state.watched.size, 0);
  store.receive(led(1, 'on_way'));
  assert.equal(store.state.watched.get(3)?.walk?.state, 'on_way', 'a computer that was started anew');
});

test('who is gone is not led', () => {
  const store = new HelperStore();
  store.state.devices = [{ device: 3, name: 'phone', role: 'device', paired: 0, last_seen: 0, online: true }];
  store.receive(led(20, 'on_way'));
  store.receive({ type: 'device', device: 3, name: 'phone', online: false, seen: null });
  assert.equal(store.state.watched.size, 0);
});

test('a device that goes may have unpaired itself: who is paired is asked anew', async (context) => {
  const asked = heldAnswers(context);
  const store = new HelperStore();
  store.state.devices = [{ device: 3, name: 'phone', role: 'device', paired: 0, last_seen: 0, online: true }];
  store.receive({ type: 'device', device: 3, name: 'phone', online: false, seen: null });
  const gone = new Promise<void>((resolve) => store.watch(['devices'], () => store.state.devices.length === 0 && resolve()));
  asked.filter(({ path }) => path === '/api/devices').forEach(({ answer }) => answer({ devices: [] }));
  assert.equal(asked.length, 1);
  await gone;
});

test('a recording, and who was seen, hold no longer than the connection', () => {
  const store = new HelperStore();
  const told: string[] = [];
  store.watch(['recording'], () => told.push(store.state.recording?.name ?? 'none'));
  store.watch(['seen'], () => told.push(`${store.state.seen.size} seen`));
  const recording = { type: 'recording', device: 3, state: 'recording', name: 'walk', frames: 1, text: '' } as const;
  store.state.devices = [{ device: 3, name: 'phone', role: 'device', paired: 0, last_seen: 0, online: true }];
  store.receive(recording);
  store.receive({ type: 'device', device: 3, name: 'phone', online: true, seen: null });
  store.forgetTold();
  store.receive(recording);
  store.receive({ ...recording, device: 1, state: 'none', name: '' });
  assert.deepEqual(told, ['none', '0 seen', 'walk', '1 seen', 'none', '0 seen', 'walk', 'none']);
});
