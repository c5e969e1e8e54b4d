// The pairing page: six digits and a name. In their place a secret may come in the address, behind #, where no server
// sees it.
import { ApiError, request, showWhy } from '../shared/api';
import { at } from '../shared/base';
import { byId, h, replaceChildren } from '../shared/dom';
import { textField } from '../shared/forms';
import type { Role } from '../shared/protocol';
import { chooseLanguage, text } from '../shared/texts';
import { codeFrom, secretFrom } from './code';
import { fieldOf, fitsAsName } from './name';

chooseLanguage();
document.title = text('pair.title');

// A link that is opened where this page is shown already changes what stands behind # alone.
window.addEventListener('hashchange', () => location.reload());

const secret = secretFrom(location.hash);
const given = codeFrom(location.hash);
if (secret || given) {
  history.replaceState(null, '', at('/pair')); // the code is not kept in the history
}
const code = textField(text('pair.code'), {
  hint: text('pair.code_hint'),
  value: given ?? '',
  attributes: { inputmode: 'numeric', autocomplete: 'one-time-code', class: 'code', maxlength: 11, required: true },
});
const name = textField(text('pair.name'), {
  hint: text('pair.name_hint'),
  value: text(/iPhone|Android.*Mobile/.test(navigator.userAgent) ? 'pair.my_phone' : 'pair.my_device'),
  attributes: { maxlength: 60, required: true },
});
const submit = h('button', { type: 'submit', class: 'primary big' }, text('pair.pair'));
const failure = h('p', { class: 'form-error', role: 'alert' });
const form = h('form', { novalidate: true, class: 'card' }, secret ? null : code.element, name.element, failure, submit);
form.addEventListener('submit', (event) => {
  event.preventDefault();
  void pair();
});
replaceChildren(byId('page'),
  h('main', { class: 'pair' },
    h('h1', {}, text('pair.heading')), h('p', { class: 'lead' }, text(secret ? 'pair.lead_link' : 'pair.lead')), form));
(secret || given ? submit : code.input).focus();

async function pair(): Promise<void> {
  [code, name].forEach((field) => field.clear());
  failure.textContent = '';
  const digits = codeFrom(code.value());
  if (!secret && !digits) {
    code.fail(text('pair.code_wrong'));
    return;
  }
  if (name.value() === '') {
    name.fail(text('pair.name_missing'));
    return;
  }
  if (!fitsAsName(name.value())) {
    name.fail(text('pair.name_long'));
    return;
  }
  submit.setAttribute('aria-disabled', 'true');
  try {
    const body = { ...(secret ? { secret } : { code: digits }), name: name.value(), cookie: true };
    const { role } = await request<{ role: Role }>('POST', '/api/pair', body);
    location.replace(at(role === 'helper' ? '/' : '/device'));
  } catch (error) {
    const field = error instanceof ApiError ? fieldOf(error.status, error.message) : null;
    if (field && !(secret && field === 'code')) {
      (field === 'code' ? code : name).fail(error);
    } else {
      showWhy(failure, error);
    }
  } finally {
    submit.removeAttribute('aria-disabled');
  }
}
