// Elements made in one expression. The pages' Content-Security-Policy forbids inline style and script, so
// attributes are set one by one and handlers are functions.

export type Child = Node | string | null | undefined | false;
type Handler = (event: Event) => void;
type Attribute = string | number | boolean | null | undefined | Handler;
export type Attributes = Record<string, Attribute>;

export function h<Tag extends keyof HTMLElementTagNameMap>(
  tag: Tag,
  attributes: Attributes = {},
  ...children: Child[]
): HTMLElementTagNameMap[Tag] {
  const element = document.createElement(tag);
  for (const [name, value] of Object.entries(attributes)) {
    setAttribute(element, name, value);
  }
  append(element, children);
  return element;
}

function setAttribute(element: HTMLElement, name: string, value: Attribute): void {
  if (value === null || value === undefined || value === false) {
    return;
  }
  if (typeof value === 'function') {
    element.addEventListener(name.replace(/^on/, ''), value);
  } else {
    element.setAttribute(name, value === true ? '' : String(value));
  }
}

export function append(parent: Node, children: readonly Child[]): void {
  for (const child of children) {
    if (child) {
      parent.appendChild(typeof child === 'string' ? document.createTextNode(child) : child);
    }
  }
}

export function replaceChildren(parent: Element, ...children: Child[]): void {
  parent.textContent = '';
  append(parent, children);
}

// Leaves alone what says that already: a screen reader would read it anew, and a press on it would be lost.
export function setText(element: Element, words: string): void {
  if (element.textContent !== words) {
    element.textContent = words;
  }
}

// The element of the page itself, which the HTML is known to hold.
export function byId(id: string): HTMLElement {
  const element = document.getElementById(id);
  if (!element) {
    throw new Error(`the page has no element '${id}'`);
  }
  return element;
}

let lastId = 0;
export function newId(stem: string): string {
  lastId += 1;
  return `${stem}-${lastId}`;
}
