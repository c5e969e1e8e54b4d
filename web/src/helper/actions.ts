// What a helper does to the home: one request each, its result said once.
import type { Announcer } from '../shared/announcer';
import type { HelperStore } from './store';

export interface Helper {
  store: HelperStore;
  announcer: Announcer;
}

// Does it, and gives what says `done`: of a dialog once it is closed, for its live regions go with it. A failure is thrown on
// to who can show it beside a field.
export async function act(helper: Helper, what: () => Promise<unknown>, done: string): Promise<() => void> {
  await what();
  return () => helper.announcer.say(done);
}

export async function actAndSay(helper: Helper, what: () => Promise<unknown>, done: string): Promise<void> {
  (await act(helper, what, done))();
}

// For actions without a form: a failure is said instead.
export function actOrSay(helper: Helper, what: () => Promise<unknown>, done: string): void {
  actAndSay(helper, what, done).catch((error: unknown) => helper.announcer.say(error, 'failed'));
}

// What walks show of their pictures is on its way.
export function mapIsMade({ store }: Helper): boolean {
  const { job } = store.state;
  return job !== null && (job.kind === 'map' || job.kind === 'prepare') && job.state === 'running';
}
