import assert from 'node:assert/strict';
import { test, type TestContext } from 'node:test';

import type { Job } from '../shared/protocol';
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
