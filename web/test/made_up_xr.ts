// A made-up phone with augmented reality, for pages in a desktop's Chromium. Each runs in the page, before its scripts.

// What a test sets while it runs.
export interface XrWorld {
  refuses: string | null; // the name of the error with which a session is refused
  isLost: boolean; // the phone does not know where it is
  hasDepth: boolean;
  degreesPerSecond: number; // that the phone turns
  isTurned: boolean; // held on its side
  sessions: number; // that were begun
  close: () => void; // as the browser's own button does
}

// A picture 240 wide and 320 high, red above and blue below, that turns; depth of 1.5 m on the right and 3 m on the left,
// as a sensor on its side gives it: 40 wide, 30 high, so 30 by 40 as the phone is held.
export function madeUpXr(): void {
  const world: XrWorld = {
    refuses: null, isLost: false, hasDepth: true, degreesPerSecond: 10, isTurned: false, sessions: 0, close: () => undefined,
  };
  (window as unknown as { xrWorld: XrWorld }).xrWorld = world;
  let angle = 0; // degrees

  const depth = (): object => {
    const [width, height] = [40, 30];
    const data = new Uint16Array(width * height);
    for (let row = 0; row < height; row += 1) {
      data.fill(row < height / 2 ? 15 : 30, row * width, (row + 1) * width);
    }
    // (u, v) of the view is (v, 1 - u) of the buffer.
    const matrix = new Float32Array([0, -1, 0, 0, 1, 0, 0, 0, 0, 0, 1, 0, 0, 1, 0, 1]);
    return { width, height, data: data.buffer, rawValueToMeters: 0.1, normDepthBufferFromNormView: { matrix } };
  };
  const view = (): object => {
    const projectionMatrix = new Float32Array(16);
    [projectionMatrix[0], projectionMatrix[5], projectionMatrix[10], projectionMatrix[11]] = [2, 1.5, -1, -1];
    const half = (angle * Math.PI) / 360;
    const [width, height] = world.isTurned ? [320, 240] : [240, 320];
    return {
      projectionMatrix, camera: { width, height },
      transform: { position: { x: 0.1, y: 1.4, z: 0 }, orientation: { x: 0, y: Math.sin(half), z: 0, w: Math.cos(half) } },
    };
  };

  class Session extends EventTarget {
    readonly depthDataFormat = 'luminance-alpha';
    private isOver = false;
    private lastTime = performance.now();

    requestReferenceSpace = async (): Promise<object> => ({});
    updateRenderState = (): void => undefined;

    requestAnimationFrame(run: (time: number, frame: object) => void): number {
      return window.setTimeout(() => {
        if (this.isOver) {
          return;
        }
        const now = performance.now();
        angle += (world.degreesPerSecond * (now - this.lastTime)) / 1000;
        this.lastTime = now;
        run(now, {
          getViewerPose: () => (world.isLost ? null : { views: [view()], emulatedPosition: false }),
          getDepthInformation: () => (world.hasDepth ? depth() : null),
        });
      }, 33);
    }

    async end(): Promise<void> {
      if (!this.isOver) {
        this.isOver = true;
        this.dispatchEvent(new Event('end'));
      }
    }
  }

  class Binding {
    private readonly texture: WebGLTexture;

    constructor(_session: object, private readonly gl: WebGL2RenderingContext) {
      this.texture = gl.createTexture();
    }

    getCameraImage({ width, height }: { width: number; height: number }): WebGLTexture {
      const canvas = document.createElement('canvas');
      Object.assign(canvas, { width, height });
      const context = canvas.getContext('2d') as CanvasRenderingContext2D;
      context.fillStyle = '#d02020';
      context.fillRect(0, 0, width, height / 2);
      context.fillStyle = '#2020d0';
      context.fillRect(0, height / 2, width, height / 2);
      for (let i = 0; i < 40; i += 1) { // something to see, away from the edges
        context.fillStyle = `rgb(${(i * 67) % 255}, ${(i * 29) % 255}, ${(i * 97) % 255})`;
        context.fillRect(40 + ((i * 83 + 5 * angle) % (width - 90)), 60 + ((i * 59) % (height - 130)), 12, 12);
      }
      const { gl } = this;
      gl.bindTexture(gl.TEXTURE_2D, this.texture);
      gl.pixelStorei(gl.UNPACK_FLIP_Y_WEBGL, true);
      gl.texImage2D(gl.TEXTURE_2D, 0, gl.RGBA, gl.RGBA, gl.UNSIGNED_BYTE, canvas);
      gl.pixelStorei(gl.UNPACK_FLIP_Y_WEBGL, false);
      gl.texParameteri(gl.TEXTURE_2D, gl.TEXTURE_MIN_FILTER, gl.LINEAR);
      gl.texParameteri(gl.TEXTURE_2D, gl.TEXTURE_WRAP_S, gl.CLAMP_TO_EDGE);
      gl.texParameteri(gl.TEXTURE_2D, gl.TEXTURE_WRAP_T, gl.CLAMP_TO_EDGE);
      return this.texture;
    }
  }

  const xr = {
    isSessionSupported: async () => true,
    requestSession: async (_mode: string, init: { requiredFeatures: string[] }) => {
      if (world.refuses) {
        throw new DOMException('refused', world.refuses);
      }
      if (!init.requiredFeatures.includes('depth-sensing') || !init.requiredFeatures.includes('camera-access')) {
        throw new DOMException('a session without pictures or depth', 'NotSupportedError');
      }
      world.sessions += 1;
      const session = new Session();
      world.close = () => void session.end();
      return session;
    },
  };
  Object.defineProperty(navigator, 'xr', { value: xr, configurable: true });
  Object.assign(window, { XRWebGLLayer: class { framebuffer = null; }, XRWebGLBinding: Binding });
}

export function noXr(): void {
  Object.defineProperty(navigator, 'xr', { value: undefined, configurable: true });
}
