// Builds a part of the page anew and leaves the focus where it was: on the element of the same data-key, or on the
// nearest one after it, or on the part itself.
import { append, type Child } from '../shared/dom';

export function rerender(part: HTMLElement, children: readonly Child[]): void {
  const active = document.activeElement;
  const hadFocus = active instanceof HTMLElement && part.contains(active);
  const key = hadFocus ? active.dataset['key'] : undefined;
  const place = hadFocus ? keyed(part).findIndex((element) => element === active) : -1;
  part.textContent = '';
  append(part, children);
  if (hadFocus) {
    const now = keyed(part);
    const next = now.find((element) => element.dataset['key'] === key) ?? now[Math.min(place, now.length - 1)] ?? part;
    if (next === part) {
      part.tabIndex = -1;
    }
    next.focus({ preventScroll: true });
  }
}

function keyed(part: HTMLElement): HTMLElement[] {
  return [...part.querySelectorAll<HTMLElement>('[data-key]')];
}
