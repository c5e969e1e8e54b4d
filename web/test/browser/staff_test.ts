import assert from 'node:assert/strict';
import { after, test } from 'node:test';

import { kStaffPassword } from '../stand_in_api';
import { closeBrowser, kDesktop, kPhone, openVisit, skipReason, withServer } from './harness';

after(closeBrowser);
const options = { skip: skipReason };

test('staff sign in, find the homes that they may open, and sign out', options, () => withServer(async (server) => {
  const visit = await openVisit(server, {});
  await visit.go('/staff');
  await visit.sees('Sign in', 'h1');
  await visit.type('anna');
  await visit.press('Sign in');
  await visit.sees('Type your password.', '.field-error');
  await visit.type('a wrong one');
  await visit.page.keyboard.press('Enter');
  await visit.sees('The name or the password is wrong.', '.form-error');
  await visit.page.keyboard.down('Control');
  await visit.page.keyboard.press('KeyA');
  await visit.page.keyboard.up('Control');
  await visit.type(kStaffPassword);
  await visit.page.keyboard.press('Enter');
  await visit.sees('Your homes', 'h1');
  assert.equal(await visit.page.evaluate(() => document.activeElement?.tagName), 'H1'); // what comes next is read
  const links = await visit.page.$$eval('main a', (all) => all.map((link) => link.getAttribute('href')));
  assert.deepEqual(links, ['/homes/flat-1/', '/homes/flat-1/device', '/homes/flat-2/device']);
  await visit.press('Sign out');
  await visit.sees('Sign in', 'h1');
  await visit.go('/staff');
  await visit.sees('Sign in', 'h1');
  await visit.close();
}));

for (const [name, size, dark] of [['small', kPhone, false], ['large', kDesktop, true]] as const) {
  test(`axe-core finds nothing on the staff's page: ${name}`, options, () => withServer(async (server) => {
    const visit = await openVisit(server, { size, dark });
    await visit.go('/staff');
    await visit.sees('Sign in', 'h1');
    await visit.assertAccessible('signing in');
    await visit.assertReflows();
    server.state.staff = 'anna';
    await visit.go('/staff');
    await visit.sees('Your homes', 'h1');
    await visit.assertAccessible('the homes');
    await visit.assertReflows();
    await visit.close();
  }));
}
