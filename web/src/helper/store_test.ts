import assert from 'node:assert/strict';
import { test } from 'node:test';

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
