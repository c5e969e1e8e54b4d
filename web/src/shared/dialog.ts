// A modal dialog with heading and close button. Escape closes it; focus goes back to where it was. While it is open a screen
// reader reaches nothing else of the page, so it has live regions of its own, which say what those behind it are told.
import { h, newId, replaceChildren, type Child } from './dom';
import { text } from './texts';

export interface OpenDialog {
  element: HTMLDialogElement;
  close: () => void;
}

interface Regions {
  urgent: HTMLElement;
  log: HTMLElement;
}

const kKeptLines = 12; // in a dialog's log
const opened: Regions[] = []; // the topmost last

// Brings the focus back to where it is now; where that was drawn anew meanwhile, to what has its data-key there, else to the
// heading of its part.
function wayBack(): () => void {
  const opener = document.activeElement;
  const around: Element[] = [];
  for (let one = opener?.parentElement; one; one = one.parentElement) {
    around.push(one);
  }
  return () => {
    const parts = around.filter(isShown);
    const keyed = [...parts[0]?.querySelectorAll<HTMLElement>('[data-key]') ?? []];
    const again = [opener, ...keyed.filter((one) => opener instanceof HTMLElement && one.dataset['key'] === opener.dataset['key'])].find(isShown);
    const heading = parts.flatMap((part) => [...part.children]).find((one) => isShown(one) && one.matches('h1, h2, h3, h4'));
    if (!again) {
      heading?.setAttribute('tabindex', '-1');
    }
    ((again ?? heading) as HTMLElement | undefined)?.focus();
  };
}

function isShown(element: Element | null): boolean {
  return element !== null && element.getClientRects().length > 0;
}

// Tells what live regions behind the dialog are told.
const behind = new MutationObserver((changes) => {
  const told = new Set<Element>();
  for (const { target, addedNodes } of changes) {
    const around = target instanceof Element ? target : target.parentElement;
    const region = around?.closest('[role=status], [role=alert], [role=log]') ?? null;
    const isLog = region?.getAttribute('role') === 'log';
    const isNews = addedNodes.length > 0 || target instanceof Text;
    if (!region || !isNews || told.has(region) || !isShown(region) || region.getAttribute('aria-live') === 'off') {
      continue;
    }
    if (!isLog) {
      told.add(region); // as a whole
    }
    (isLog ? [...addedNodes] : [region]).forEach((node) => sayFrom(region, node));
  }
});

// By the topmost dialog, unless the region is in it or says it there itself.
function sayFrom(region: Element, node: Node): void {
  const top = opened[opened.length - 1];
  const words = (node.textContent ?? '').trim();
  if (words !== '' && !region.closest('dialog')?.contains(top?.log ?? null) && !region.closest('[data-says-in-dialog]')) {
    const marked = node instanceof HTMLElement && (node.lang ? node : node.querySelector<HTMLElement>('[lang]'));
    const lang = marked && marked.lang;
    sayInDialog(h('p', lang ? { lang } : {}, words), region.getAttribute('role') === 'alert');
  }
}

// Has the line read from the topmost dialog that is open. False where none is: then the page itself is read.
export function sayInDialog(line: HTMLElement, isUrgent: boolean): boolean {
  const top = opened[opened.length - 1];
  if (!top) {
    return false;
  }
  replaceChildren(top.urgent, isUrgent && line);
  if (!isUrgent) {
    top.log.append(line);
  }
  while (top.log.childElementCount > kKeptLines) {
    top.log.firstElementChild?.remove();
  }
  return true;
}

export function openDialog(title: string, content: readonly Child[], closed: () => void = () => undefined): OpenDialog {
  const goBack = wayBack();
  const id = newId('dialog');
  const element = h('dialog', { 'aria-labelledby': id, class: 'dialog' });
  const regions = {
    urgent: h('div', { class: 'form-error', role: 'alert' }),
    log: h('div', { class: 'visually-hidden', role: 'log', 'aria-live': 'polite', 'aria-label': text('said.label') }),
  };
  // At once, and not when the browser gets to tell that it is closed: focus may be elsewhere by then.
  const close = (): void => {
    element.close();
    leave();
  };
  element.append(
    h('div', { class: 'dialog-head' },
      h('h2', { id, tabindex: '-1' }, title),
      h('button', { type: 'button', class: 'quiet-button', onclick: close }, text('dialog.close'))),
    regions.urgent, regions.log,
    ...content.filter((child): child is Node => child instanceof Node));
  const leave = (): void => {
    if (!element.isConnected) {
      return;
    }
    element.remove();
    opened.splice(opened.indexOf(regions), 1);
    if (opened.length === 0) {
      behind.disconnect();
    }
    goBack();
    closed();
  };
  element.addEventListener('close', leave); // by a gesture of the browser's own
  // By itself not from a field for searching in WebKit, which empties that instead.
  element.addEventListener('keydown', (event) => {
    if (event.key === 'Escape' && !event.defaultPrevented && !event.isComposing) {
      event.preventDefault();
      close();
    }
  });
  document.body.append(element);
  opened.push(regions);
  behind.observe(document.body, { childList: true, characterData: true, subtree: true });
  element.showModal();
  (element.querySelector<HTMLElement>('[autofocus]') ?? element.querySelector<HTMLElement>('h2'))?.focus();
  return { element, close };
}
