// A phone with augmented reality that plays a simulated walk: its pictures, its depth, where it truly was. Runs in the page,
// before its scripts; the page is given `playedFrames`.

export interface PlayedFrame {
  color: string; // base64
  depth: string; // base64 of 16 bits, little endian, 5000 per metre
  room: string;
  position: number[]; // WebXR's: y up
  orientation: number[];
}

export interface Played {
  next: number; // of the frame that is shown
  room: string;
  isOver: boolean;
}

export function playedXr(): void {
  const [width, height, focal] = [320, 240, 262];
  const kShownFor = 1; // pictures that the page takes
  const world = window as unknown as { playedFrames: (first: number) => Promise<PlayedFrame[]>; played: Played };
  world.played = { next: 0, room: '', isOver: false };
  const frames: { picture: ImageBitmap; depth: ArrayBuffer; told: PlayedFrame }[] = [];
  const bytesOf = (base64: string): Uint8Array<ArrayBuffer> => Uint8Array.from(atob(base64), (one) => one.charCodeAt(0));
  const load = async (): Promise<void> => {
    for (let more = await world.playedFrames(0); more.length > 0; more = await world.playedFrames(frames.length)) {
      for (const told of more) {
        frames.push({ picture: await createImageBitmap(new Blob([bytesOf(told.color)])), depth: bytesOf(told.depth).buffer, told });
      }
    }
  };
  const now = (): (typeof frames)[number] => frames[Math.min(world.played.next, frames.length - 1)] as (typeof frames)[number];
  const view = (): object => {
    const projectionMatrix = new Float32Array(16);
    [projectionMatrix[0], projectionMatrix[5], projectionMatrix[10], projectionMatrix[11]] = [(2 * focal) / width, (2 * focal) / height, -1, -1];
    const [[x, y, z], [qx, qy, qz, qw]] = [now().told.position, now().told.orientation];
    return { projectionMatrix, camera: { width, height }, transform: { position: { x, y, z }, orientation: { x: qx, y: qy, z: qz, w: qw } } };
  };
  const identity = new Float32Array([1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1]);

  class Session extends EventTarget {
    readonly depthDataFormat = 'unsigned-short';
    private isOver = false;
    requestReferenceSpace = async (): Promise<object> => ({});
    updateRenderState = (): void => undefined;
    requestAnimationFrame(run: (time: number, frame: object) => void): number {
      return window.setTimeout(() => this.isOver || run(performance.now(), {
        getViewerPose: () => ({ views: [view()], emulatedPosition: false }),
        getDepthInformation: () => ({ width, height, data: now().depth, rawValueToMeters: 1 / 5000, normDepthBufferFromNormView: { matrix: identity } }),
      }), 33);
    }
    async end(): Promise<void> {
      this.isOver = true;
      this.dispatchEvent(new Event('end'));
    }
  }

  class Binding {
    private taken = 0;
    private readonly texture: WebGLTexture;
    constructor(_session: object, private readonly gl: WebGL2RenderingContext) {
      this.texture = gl.createTexture();
    }
    // The view is asked for first: the picture, its pose and depth belong together until the next one.
    getCameraImage(): WebGLTexture {
      const { gl } = this;
      gl.bindTexture(gl.TEXTURE_2D, this.texture);
      gl.pixelStorei(gl.UNPACK_FLIP_Y_WEBGL, true);
      const canvas = document.createElement('canvas');
      Object.assign(canvas, { width, height });
      canvas.getContext('2d')?.drawImage(now().picture, 0, 0);
      gl.texImage2D(gl.TEXTURE_2D, 0, gl.RGBA, gl.RGBA, gl.UNSIGNED_BYTE, canvas);
      gl.pixelStorei(gl.UNPACK_FLIP_Y_WEBGL, false);
      gl.texParameteri(gl.TEXTURE_2D, gl.TEXTURE_MIN_FILTER, gl.LINEAR);
      gl.texParameteri(gl.TEXTURE_2D, gl.TEXTURE_WRAP_S, gl.CLAMP_TO_EDGE);
      gl.texParameteri(gl.TEXTURE_2D, gl.TEXTURE_WRAP_T, gl.CLAMP_TO_EDGE);
      this.taken += 1;
      window.queueMicrotask(() => {
        world.played.next = Math.floor(this.taken / kShownFor);
        world.played.room = now().told.room;
        world.played.isOver = world.played.next >= frames.length;
      });
      return this.texture;
    }
  }
  const xr = {
    isSessionSupported: async () => true,
    requestSession: async () => {
      await load();
      return new Session();
    },
  };
  Object.defineProperty(navigator, 'xr', { value: xr });
  Object.assign(window, { XRWebGLLayer: class { framebuffer = null; }, XRWebGLBinding: Binding });
}
