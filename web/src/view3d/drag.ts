// Fingers and the mouse on the picture: one turns, two (or Shift) move and zoom, a tap chooses. What they do, the
// buttons below the picture do, too.
export interface DragActions {
  turn: (right: number, up: number) => void; // pixels
  move: (right: number, up: number) => void;
  zoom: (factor: number) => void;
  tap: (x: number, y: number) => void; // -1 to 1, y up
}

const kTapWithin_px = 6;

export function drag(element: HTMLElement, actions: DragActions): void {
  const pointers = new Map<number, { x: number; y: number }>();
  let wandered = 0;
  element.addEventListener('pointerdown', (event) => {
    element.setPointerCapture(event.pointerId);
    wandered = pointers.size === 0 ? 0 : Infinity; // two fingers are no tap
    pointers.set(event.pointerId, { x: event.clientX, y: event.clientY });
  });
  element.addEventListener('pointermove', (event) => {
    const last = pointers.get(event.pointerId);
    if (!last) {
      return;
    }
    const before = spread(pointers);
    const [right, up] = [event.clientX - last.x, last.y - event.clientY];
    wandered += Math.hypot(right, up);
    pointers.set(event.pointerId, { x: event.clientX, y: event.clientY });
    if (pointers.size === 1 && !event.shiftKey && event.buttons !== 2) {
      actions.turn(right, -up);
    } else {
      actions.move(right / pointers.size, up / pointers.size);
      const after = spread(pointers);
      if (before > 0 && after > 0) {
        actions.zoom(before / after);
      }
    }
  });
  const over = (event: PointerEvent): void => {
    if (pointers.delete(event.pointerId) && event.type === 'pointerup' && wandered < kTapWithin_px) {
      const box = element.getBoundingClientRect();
      actions.tap(((event.clientX - box.left) / box.width) * 2 - 1, 1 - ((event.clientY - box.top) / box.height) * 2);
    }
  };
  element.addEventListener('pointerup', over);
  element.addEventListener('pointercancel', over);
  element.addEventListener('contextmenu', (event) => event.preventDefault());
  // The wheel scrolls the page unless Ctrl (or two fingers on a touch pad, which say so) zooms.
  element.addEventListener('wheel', (event) => {
    if (event.ctrlKey) {
      event.preventDefault();
      actions.zoom(Math.exp(event.deltaY * 0.01));
    }
  }, { passive: false });
}

// Distance of two fingers; 0 where there are not two.
function spread(pointers: ReadonlyMap<number, { x: number; y: number }>): number {
  const [a, b] = [...pointers.values()];
  return a && b ? Math.hypot(a.x - b.x, a.y - b.y) : 0;
}
