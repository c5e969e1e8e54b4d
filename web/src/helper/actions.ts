// What a helper does to the home: one request each, its result said once.
import type { Announcer } from '../shared/announcer';
import { messageOf } from '../shared/api';
import type { HelperStore } from './store';

export interface Helper {
  store: HelperStore;
  announcer: Announcer;
}

// Does it and says `done`; a failure is thrown on to who can show it beside a field.
export async function act(helper: Helper, what: () => Promise<unknown>, done: string): Promise<void> {
  await what();
  helper.announcer.say(done);
}

// For actions without a form: a failure is said instead.
export function actOrSay(helper: Helper, what: () => Promise<unknown>, done: string): void {
  act(helper, what, done).catch((error: unknown) => helper.announcer.say(messageOf(error), 'failed'));
}
