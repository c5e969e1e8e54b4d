// Builds a part of the page anew and leaves the focus where it was: on the element of the same data-key, or on the
// nearest one after it, or on the part itself. What is in the part already stays there.
import type { Child } from '../shared/dom';

export function rerender(part: HTMLElement, children: readonly Child[]): void {
  const active = document.activeElement;
  const hadFocus = active instanceof HTMLElement && part.contains(active);
  const key = hadFocus ? active.dataset['key'] : undefined;
  const place = hadFocus ? keyed(part).findIndex((element) => element === active) : -1;
  replaceOthers(part, children.filter((child): child is Node | string => Boolean(child)));
  if (hadFocus && document.activeElement !== active) {
    const now = keyed(part);
    const next = now.find((element) => element.dataset['key'] === key) ?? now[Math.min(place, now.length - 1)] ?? part;
    if (next === part) {
      part.tabIndex = -1;
    }
    next.focus({ preventScroll: true });
  }
}

function replaceOthers(part: HTMLElement, children: readonly (Node | string)[]): void {
  [...part.childNodes].filter((one) => !children.includes(one)).forEach((one) => one.remove());
  children.forEach((child, i) => {
    if (part.childNodes[i] !== child) {
      part.insertBefore(typeof child === 'string' ? document.createTextNode(child) : child, part.childNodes[i] ?? null);
    }
  });
}

function keyed(part: HTMLElement): HTMLElement[] {
  return [...part.querySelectorAll<HTMLElement>('[data-key]')];
}

// Shows a part or hides it; the focus that goes with it goes on to the heading of the panel.
export function showPart(part: HTMLElement, isShown: boolean): void {
  const losesFocus = !isShown && part.contains(document.activeElement);
  part.hidden = !isShown;
  if (losesFocus) {
    part.closest('.panel')?.querySelector<HTMLElement>('h2')?.focus({ preventScroll: true });
  }
}

export interface Row<Item> {
  element: HTMLElement;
  show: (item: Item, place: number) => void;
}

// Shows items in rows that stay as long as their item does, so that a press ends on the button on which it began, and nobody is
// read anew what has the focus.
export function keptRows<Item>(list: HTMLElement, idOf: (item: Item) => unknown, make: (item: Item) => Row<Item>): (items: readonly Item[]) => void {
  let rows = new Map<unknown, Row<Item>>();
  return (items) => {
    rows = new Map(items.map((item) => [idOf(item), rows.get(idOf(item)) ?? make(item)]));
    items.forEach((item, place) => rows.get(idOf(item))?.show(item, place));
    rerender(list, [...rows.values()].map(({ element }) => element));
  };
}
