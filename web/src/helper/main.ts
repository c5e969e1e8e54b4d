// The helper's page.
import { Announcer } from '../shared/announcer';
import { ApiError, request, showWhy, whenSilent } from '../shared/api';
import { at } from '../shared/base';
import { browserSession } from '../shared/browser_session';
import { byId, h, replaceChildren } from '../shared/dom';
import { kProtocolVersion, type Me } from '../shared/protocol';
import { chooseLanguage, language, text } from '../shared/texts';
import { devicesPanel } from './devices_panel';
import { forgetPanel } from './forget_panel';
import { homePanel } from './home_panel';
import { ledPanel } from './led_panel';
import { recognisePanel } from './recognise_panel';
import { makeShell } from './shell';
import { HelperStore } from './store';
import { walksPanel } from './walks_panel';

chooseLanguage();
document.title = text('helper.title');
const page = byId('page');
void begin();

async function begin(): Promise<void> {
  try {
    const me = await request<Me>('GET', '/api/me');
    if (me.role !== 'helper') {
      location.replace(at('/device')); // a device's page
      return;
    }
    await open(me);
  } catch (error) {
    if (error instanceof ApiError && error.status === 401) {
      location.replace(at('/pair'));
    } else {
      showFailure(error);
    }
  }
}

async function open(me: Me): Promise<void> {
  const helper = { store: new HelperStore(), announcer: new Announcer() };
  await helper.store.refreshAll();
  const session = browserSession({
    hello: () => ({
      type: 'hello', version: kProtocolVersion, name: me.name, kind: 'page', camera: null, language: language(),
      distances: 'metres', step_m: 0.7, callouts: false, may_watch: false,
    }),
    onMessage: (message) => helper.store.receive(message),
    onOnline: () => {
      helper.store.setOnline(true);
      watching = false; // the computer knows of nothing yet
      watch();
      if (wasLost) {
        wasLost = false;
        helper.announcer.say(text('helper.back'));
        void helper.store.refreshAll().catch(() => undefined); // what changed meanwhile
      }
    },
    onOffline: () => {
      helper.store.setOnline(false);
      helper.store.forgetTold(); // nobody knows what is so now
      if (!wasLost) {
        wasLost = true;
        helper.announcer.say(text('helper.lost'), 'failed');
      }
    },
  });
  let wasLost = false;
  // While that part is shown to somebody: whoever is led is told of it.
  let watching = false;
  const watch = (): void => {
    const watches = location.hash === '#led' && document.visibilityState === 'visible';
    if (watches !== watching && session.send({ type: 'watch', on: watches })) {
      watching = watches;
      helper.store.forgetWatched();
    }
  };
  window.addEventListener('hashchange', watch);
  document.addEventListener('visibilitychange', watch);
  replaceChildren(page, makeShell(helper, [
    { name: 'home', title: text('nav.home'), make: () => homePanel(helper) },
    { name: 'led', title: text('nav.led'), make: () => ledPanel(helper) },
    { name: 'walks', title: text('nav.walks'), make: () => walksPanel(helper, me) },
    { name: 'recognise', title: text('nav.recognise'), make: () => recognisePanel(helper) },
    { name: 'devices', title: text('nav.devices'), make: () => devicesPanel(helper, me) },
    { name: 'forget', title: text('nav.forget'), make: () => forgetPanel(helper) },
  ]));
  // The socket does not notice by itself that the network is dead.
  whenSilent(() => {
    if (session.online) {
      session.reconnect();
    }
  });
  session.connect();
}

function showFailure(error: unknown): void {
  const why = h('p', { role: 'alert' });
  showWhy(why, error);
  replaceChildren(page,
    h('main', { class: 'failure' },
      h('h1', {}, 'Roomwise'),
      why,
      h('button', { type: 'button', class: 'primary', onclick: () => location.reload() }, text('helper.again'))));
}
