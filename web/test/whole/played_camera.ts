// A phone's camera in which a walk is played: it shows one picture, and the next once the computer has looked at it, up to
// the one where its walker stands still. So who walks is never ahead of what is said to them. Runs in the page, before its
// scripts; the page is given `playedPicture`.

export interface PlayedCamera {
  shown: number; // which picture
  until: number; // where the walker stands still
}

export function playedCamera(): void {
  const [width, height] = [240, 320];
  const world = window as unknown as { playedPicture: (which: number) => Promise<string>; playedCamera: PlayedCamera };
  const played: PlayedCamera = { shown: 0, until: 0 };
  world.playedCamera = played;
  const canvas = document.createElement('canvas');
  Object.assign(canvas, { width, height });
  let picture: ImageBitmap | null = null;
  const show = async (which: number): Promise<void> => {
    const bytes = Uint8Array.from(atob(await world.playedPicture(which)), (one) => one.charCodeAt(0));
    picture = await createImageBitmap(new Blob([bytes]));
    played.shown = which;
  };
  navigator.mediaDevices.getUserMedia = async () => {
    await show(0);
    window.setInterval(() => picture && canvas.getContext('2d')?.drawImage(picture, 0, 0), 50);
    return canvas.captureStream();
  };
  window.WebSocket = class extends WebSocket {
    constructor(...address: ConstructorParameters<typeof WebSocket>) {
      super(...address);
      this.addEventListener('message', ({ data }) => {
        const isSeen = typeof data === 'string' && (JSON.parse(data) as { type: string }).type === 'seen';
        if (isSeen && picture && played.shown < played.until) {
          void show(played.shown + 1);
        }
      });
    }
  };
}
