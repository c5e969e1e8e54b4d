// Who is connected, who may connect.
import { request, showWhy } from '../shared/api';
import { openDialog } from '../shared/dialog';
import { h, replaceChildren, setText } from '../shared/dom';
import { radioField, textField } from '../shared/forms';
import { icon } from '../shared/icons';
import type { Authority, Device, Me, PairingCode, Role } from '../shared/protocol';
import { counted, formatTime, text } from '../shared/texts';
import { act, type Helper } from './actions';
import { openFormDialog, required } from '../shared/form_dialog';
import { qrPicture } from './qr';
import { verdictWords } from './recognise_panel';
import { keptRows, type Row } from './rerender';
import { card, panel } from './shell';

export function devicesPanel(helper: Helper, me: Me): HTMLElement {
  const list = h('ul', { class: 'devices' });
  const show = keptRows(list, ({ device }: Device) => device, (device) => deviceRow(helper, me, device));
  helper.store.watch(['devices', 'seen'], () => show(helper.store.state.devices));
  return panel(text('nav.devices'), card(text('devices.paired'), list), pairCard(helper), authorityCard());
}

function deviceRow(helper: Helper, me: Me, first: Device): Row<Device> {
  let device = first;
  const own = device.device === me.device;
  const name = h('bdi'); // of any script
  const state = h('p');
  const facts = h('p', { class: 'hint' });
  const button = (what: 'rename' | 'revoke', run: () => void): HTMLElement =>
    h('button', { type: 'button', class: 'small', 'data-key': `${what} ${device.device}`, onclick: run }, text(`devices.${what}`));
  const buttons = [button('rename', () => rename(helper, device)), button('revoke', () => revoke(helper, device, own))];
  return {
    element: h('li', {}, h('div', {}, h('p', { class: 'device-name' }, name, own ? ` (${text('devices.this_one')})` : null), state, facts), h('div', { class: 'row tight' }, ...buttons)),
    show: (now) => {
      device = now;
      setText(name, device.name);
      buttons.forEach((one) => one.setAttribute('aria-label', `${one.textContent} ${device.name}`));
      const isOnline = device.online ? text('phone.connected') : text('phone.not_connected');
      if (state.textContent !== isOnline) {
        state.className = `chip ${device.online ? 'good' : 'off'}`;
        replaceChildren(state, icon(device.online ? 'tick' : 'cross'), isOnline);
      }
      setText(facts, factsOf(helper, device));
    },
  };
}

function factsOf(helper: Helper, device: Device): string {
  const seen = device.online ? helper.store.state.seen.get(device.device)?.seen : null;
  return [
    text(`devices.role_${device.role}`),
    device.online ? '' : text('devices.last_seen', { time: formatTime(device.last_seen) }),
    seen ? text('devices.sees', { verdict: verdictWords(seen.verdict, seen.room, seen.probability) }) : '',
  ].filter((fact) => fact !== '').join(' · ');
}

function rename(helper: Helper, device: Device): void {
  const name = textField(text('devices.name'), { value: device.name, attributes: { maxlength: 40 } });
  openFormDialog({
    title: text('devices.rename_title', { device: device.name }),
    fields: [name],
    submit: text('dialog.save'),
    check: () => required(name, text('devices.name_missing')),
    run: () => act(helper, async () => {
      await request('PUT', `/api/devices/${device.device}`, { name: name.value() });
      await helper.store.refreshDevices();
    }, text('devices.renamed', { device: name.value() })),
  });
}

function revoke(helper: Helper, device: Device, own: boolean): void {
  openFormDialog({
    title: text('devices.revoke_title', { device: device.name }),
    explain: text(own ? 'devices.revoke_own' : 'devices.revoke_explain'),
    fields: [],
    submit: text('devices.revoke'),
    dangerous: true,
    run: () => act(helper, async () => {
      await request('DELETE', `/api/devices/${device.device}`);
      await helper.store.refreshDevices();
    }, text('devices.revoked', { device: device.name })),
  });
}

function pairCard(helper: Helper): HTMLElement {
  let role: Role = 'device';
  const failure = h('p', { class: 'form-error', role: 'alert' });
  const pair = async (): Promise<void> => {
    failure.textContent = '';
    try {
      showCode(helper, await request<PairingCode>('POST', '/api/codes', { role }));
    } catch (error) {
      showWhy(failure, error);
    }
  };
  return card(text('devices.pair'),
    radioField(text('devices.pair_as'), [
      { value: 'device', label: text('devices.as_device') },
      { value: 'helper', label: text('devices.as_helper') },
    ], role, (chosen) => (role = chosen as Role)),
    failure,
    h('div', { class: 'row' }, h('button', { type: 'button', class: 'primary', onclick: () => void pair() }, text('devices.make_code'))));
}

function showCode(helper: Helper, { code, valid_s, digits_wait_s, address, qr }: PairingCode): void {
  const page = address.split('#')[0] ?? address; // what follows is for the camera
  const grouped = `${code.slice(0, 3)} ${code.slice(3)}`;
  openDialog(text('devices.code_title'), [
    h('p', {}, text('devices.code_explain', { minutes: counted('devices.minutes', Math.round(valid_s / 60)) })),
    // Read digit by digit.
    h('p', { class: 'big-code', 'aria-hidden': 'true' }, grouped),
    h('p', { class: 'visually-hidden' }, text('devices.code_is', { code: [...code].join(' ') })),
    digits_wait_s > 0 && h('p', { role: 'alert' }, text('devices.digits_wait', { seconds: digits_wait_s })),
    qrPicture(qr, text('devices.qr', { address: page })),
    h('p', { class: 'hint' }, page),
  ], () => void helper.store.refreshDevices().catch(() => undefined));
}

// What to install on a phone so that its browser warns no more. A home from before there were authorities has none.
function authorityCard(): HTMLElement {
  const place = card(text('authority.title'));
  place.hidden = true;
  void request<Authority>('GET', '/api/authority').then(({ name, fingerprint, file }) => {
    const steps = (list: string[]): HTMLElement => h('ol', {}, ...list.map((step) => h('li', {}, step)));
    place.append(
      h('p', {}, text('authority.explain')),
      h('p', {}, h('a', { href: file }, text('authority.get'))),
      h('h3', {}, 'iPhone, iPad'), steps([text('authority.iphone_1'), text('authority.iphone_2', { name })]),
      h('h3', {}, 'Android'), steps([text('authority.android_1'), text('authority.android_2')]),
      h('p', {}, text('authority.compare', { name })),
      h('p', { class: 'hint fingerprint' }, fingerprint));
    place.hidden = false;
  }, () => undefined);
  return place;
}
