// Where the staff of who keeps many homes sign in, and find those that they may open.
import { ApiError, messageOf, request, showWhy } from '../shared/api';
import { byId, h, replaceChildren } from '../shared/dom';
import { textField } from '../shared/forms';
import type { Role } from '../shared/protocol';
import { chooseLanguage, text } from '../shared/texts';
import { pathsOf } from './paths';

interface Staff {
  name: string;
  homes: { name: string; role: Role }[];
}

chooseLanguage();
document.title = text('staff.title');
const page = h('main', { class: 'staff' });
replaceChildren(byId('page'), page);
void begin();

async function begin(): Promise<void> {
  try {
    showHomes(await request<Staff>('GET', '/api/staff/me'), false);
  } catch (error) {
    const isStranger = error instanceof ApiError && error.status === 401;
    showSignIn(isStranger ? '' : messageOf(error));
  }
}

function showSignIn(why: string): void {
  const name = textField(text('staff.name'), { attributes: { autocomplete: 'username', autocapitalize: 'none', spellcheck: 'false', required: true } });
  const password = textField(text('staff.password'), { attributes: { type: 'password', autocomplete: 'current-password', required: true } });
  const failure = h('p', { class: 'form-error', role: 'alert' }, why);
  const submit = h('button', { type: 'submit', class: 'primary big' }, text('staff.sign_in'));
  const form = h('form', { novalidate: true, class: 'card' }, name.element, password.element, failure, submit);
  form.addEventListener('submit', (event) => {
    event.preventDefault();
    void signIn();
  });
  replaceChildren(page, h('h1', {}, text('staff.heading')), h('p', { class: 'lead' }, text('staff.lead')), form);
  name.input.focus();

  async function signIn(): Promise<void> {
    [name, password].forEach((field) => field.clear());
    failure.textContent = '';
    if (name.value() === '') {
      name.fail(text('staff.name_missing'));
      return;
    }
    if (password.value() === '') {
      password.fail(text('staff.password_missing'));
      return;
    }
    submit.setAttribute('aria-disabled', 'true');
    try {
      showHomes(await request<Staff>('POST', '/api/staff/sign-in', { name: name.value(), password: password.value() }), true);
    } catch (error) {
      const isWrong = error instanceof ApiError && error.status === 401;
      failure.textContent = isWrong ? text('staff.wrong') : messageOf(error);
      password.input.focus();
    } finally {
      submit.removeAttribute('aria-disabled');
    }
  }
}

// `moves`: the form that had the focus is gone, so that the heading takes it.
function showHomes(staff: Staff, moves: boolean): void {
  const heading = h('h1', { tabindex: '-1' }, text('staff.homes'));
  const failure = h('p', { class: 'form-error', role: 'alert' });
  const leave = h('button', { type: 'button' }, text('staff.sign_out'));
  leave.addEventListener('click', () => {
    request('POST', '/api/staff/sign-out', {}).then(
      () => showSignIn(''),
      (error: unknown) => showWhy(failure, error),
    );
  });
  const list = h('ul', { class: 'homes' }, ...staff.homes.map((home) => {
    const paths = pathsOf(home.name);
    return h('li', { class: 'card' },
      h('h2', {}, home.name),
      home.role === 'helper' ? h('p', {}, h('a', { href: paths.helper }, text('staff.look_after', { home: home.name }))) : null,
      h('p', {}, h('a', { href: paths.device }, text('staff.walk_in', { home: home.name }))));
  }));
  replaceChildren(page, heading, h('p', { class: 'lead' }, text('staff.signed_in', { name: staff.name })),
    staff.homes.length > 0 ? list : h('p', {}, text('staff.no_homes')), failure, leave);
  if (moves) {
    heading.focus();
  }
}
