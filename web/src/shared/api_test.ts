import assert from 'node:assert/strict';
import { test, type TestContext } from 'node:test';

import { ApiError, request, spokenFailure, whenSilent } from './api';
import { setLanguage } from './texts';

// A computer that answers what `answers` lets it, and timers that run when the test says so.
function makeComputer(context: TestContext, answers: (path: string) => boolean) {
  const timers = new Map<number, () => void>();
  let lastTimer = 0;
  const world = { answers, silences: 0, given: new Map<string, (response: Response) => void>(), timers };
  const setTimer = (run: () => void): number => {
    timers.set(++lastTimer, run);
    return lastTimer;
  };
  context.mock.method(globalThis, 'setTimeout', setTimer as never);
  context.mock.method(globalThis, 'setInterval', setTimer as never);
  context.mock.method(globalThis, 'clearTimeout', ((timer: number) => timers.delete(timer)) as never);
  context.mock.method(globalThis, 'clearInterval', ((timer: number) => timers.delete(timer)) as never);
  context.mock.method(globalThis, 'fetch', ((path: string, { signal }: { signal: AbortSignal }) =>
    new Promise<Response>((resolve, reject) => {
      signal.addEventListener('abort', () => reject(new Error('aborted')));
      world.given.set(path, resolve);
      if (world.answers(path)) {
        resolve(new Response('{"status": "ok"}'));
      }
    })) as never);
  whenSilent(() => (world.silences += 1));
  return world;
}

const runNewest = (timers: Map<number, () => void>): void => [...timers.values()].pop()?.();
// All promises that can go on have gone on; not by a timer, which the tests hold.
const settled = (): Promise<void> => new Promise((resolve) => setImmediate(resolve));

test('a request without an answer is given up where the computer is silent altogether, and that is told', async (context) => {
  const computer = makeComputer(context, () => false);
  const asked = assert.rejects(request('POST', '/api/learn'), (error) => error instanceof ApiError && error.status === 0);
  runNewest(computer.timers); // the request has waited long enough: is the computer there?
  assert.ok(computer.given.has('/health'));
  assert.equal(computer.silences, 0);
  runNewest(computer.timers); // that waited, too
  await asked;
  assert.equal(computer.silences, 1);
  assert.equal(computer.timers.size, 0);
});

test('long work is waited for where the computer is there', async (context) => {
  const computer = makeComputer(context, (path) => path === '/health');
  const asked = request<{ rooms: number }>('DELETE', '/api/home');
  for (let i = 0; i < 5; i += 1) {
    runNewest(computer.timers);
    await settled();
  }
  computer.given.get('/api/home')?.(new Response('{"rooms": 3}'));
  assert.deepEqual(await asked, { rooms: 3 });
  assert.equal(computer.silences, 0);
  assert.equal(computer.timers.size, 0);
});

test('an answer that comes while the computer is looked for is taken', async (context) => {
  const computer = makeComputer(context, () => false);
  const asked = request<{ rooms: number }>('GET', '/api/home');
  runNewest(computer.timers);
  computer.given.get('/api/home')?.(new Response('{"rooms": 3}'));
  assert.deepEqual(await asked, { rooms: 3 });
  runNewest(computer.timers);
  await settled();
  assert.equal(computer.silences, 0);
});

test('what the pages have words for is told in their language, the rest in the English of the computer', async (context) => {
  const computer = makeComputer(context, () => false);
  setLanguage('de');
  context.after(() => setLanguage('en'));
  const refused = async (status: number, body: object, headers: Record<string, string> = {}): Promise<ApiError> => {
    const asked = request('POST', '/api/pair', {}).then(() => assert.fail('it was refused'), (error: unknown) => error as ApiError);
    computer.given.get('/api/pair')?.(new Response(JSON.stringify(body), { status, headers }));
    return asked;
  };
  const over = await refused(401, { error: 'the code is wrong', message: 'code_over' });
  assert.equal(over.message, 'Der Code ist falsch oder gilt nicht mehr. Lassen Sie sich einen neuen geben.');
  assert.equal(over.isEnglish, false);
  const many = await refused(429, { error: 'too many wrong codes', message: 'many_codes' }, { 'Retry-After': '30' });
  assert.match(many.message, /Warten Sie 30 Sekunden/);
  const other = await refused(409, { error: "there is a room 'hall' already", message: 'unheard_of' });
  assert.equal(other.message, "there is a room 'hall' already");
  assert.equal(other.isEnglish, true);
  assert.equal(spokenFailure(other), 'Der Computer der Wohnung hat abgelehnt (409).', 'a German voice speaks no English');
  assert.equal(spokenFailure(many), many.message);
  setLanguage('en');
  assert.equal(spokenFailure(other), other.message);
});
