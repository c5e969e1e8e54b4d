// A modal dialog with heading and close button. Escape closes it; focus goes back to where it was.
import { h, newId, type Child } from './dom';
import { text } from './texts';

export interface OpenDialog {
  element: HTMLDialogElement;
  close: () => void;
}

export function openDialog(title: string, content: readonly Child[], closed: () => void = () => undefined): OpenDialog {
  const opener = document.activeElement;
  const id = newId('dialog');
  const element = h('dialog', { 'aria-labelledby': id, class: 'dialog' });
  // At once, and not when the browser gets to tell that it is closed: focus may be elsewhere by then.
  const close = (): void => {
    element.close();
    leave();
  };
  element.append(
    h('div', { class: 'dialog-head' },
      h('h2', { id, tabindex: '-1' }, title),
      h('button', { type: 'button', class: 'quiet-button', onclick: close }, text('dialog.close'))),
    ...content.filter((child): child is Node => child instanceof Node));
  const leave = (): void => {
    if (!element.isConnected) {
      return;
    }
    element.remove();
    if (opener instanceof HTMLElement && opener.isConnected) {
      opener.focus();
    }
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
  element.showModal();
  (element.querySelector<HTMLElement>('[autofocus]') ?? element.querySelector<HTMLElement>('h2'))?.focus();
  return { element, close };
}
