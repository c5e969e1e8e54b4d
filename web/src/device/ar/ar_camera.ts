// The phone's camera in a session of augmented reality: pictures with depth, intrinsics and where the phone was. One
// picture at a time is taken, within the session's callback, since the camera's texture holds no longer.
import type { CameraDescription, FramePose, Intrinsics } from '../../shared/protocol';
import { greyFromRgba, type GreyPicture } from '../../shared/picture_quality';
import { kGreySide, kPictureSide, type FramePicture, type PictureSource } from '../../shared/picture_source';
import { GlPicture } from './gl_picture';
import { encodePng16 } from './png16';
import { depthOfView, intrinsicsOf, measured, poseOf, type DepthGrid } from './view_geometry';
import { xrSystem, type XrBinding, type XrFrame, type XrReferenceSpace, type XrSession, type XrView, type XrWindow } from './webxr';

export const kTakeEveryMs = 200;
const kJpegQuality = 0.85;
const kUnitsPerMetre = 1000;

export type ArFailure = 'refused' | 'unsupported' | 'failed';

// What the browser's refusal means.
export function failureOf(error: unknown): ArFailure {
  const name = error instanceof DOMException ? error.name : '';
  if (name === 'NotAllowedError' || name === 'SecurityError') {
    return 'refused';
  }
  return name === 'NotSupportedError' ? 'unsupported' : 'failed';
}

// Whether this browser can begin such a session at all. Depth and camera are known only once it is asked for.
export async function canRecord(): Promise<boolean> {
  try {
    return 'XRWebGLBinding' in window && ((await xrSystem()?.isSessionSupported('immersive-ar')) ?? false);
  } catch {
    return false;
  }
}

// What a picture was taken of, as it is told to who coaches the walk.
export interface Taken {
  t: number;
  pose: FramePose | null;
  hasDepth: boolean;
  isTurned: boolean; // the phone is held another way than at the beginning
}

interface Picture extends Taken {
  rgba: Uint8ClampedArray<ArrayBuffer>;
  camera: Intrinsics;
  depth: DepthGrid | null;
}

export interface ArHandlers {
  taken: (what: Taken) => void; // with every picture
  ended: () => void; // once, also where nobody asked for it
}

export class ArCamera implements PictureSource {
  private picture: Picture | null = null;
  private first: Intrinsics | null = null;
  private count = 0;
  private takenAt = -Infinity;
  private isOver = false;
  private readonly canvas = document.createElement('canvas');
  private readonly small = document.createElement('canvas');

  private constructor(
    private readonly session: XrSession, private readonly space: XrReferenceSpace, private readonly gl: WebGL2RenderingContext,
    private readonly layer: { framebuffer: WebGLFramebuffer | null }, private readonly binding: XrBinding,
    private readonly reader: GlPicture, private readonly handlers: ArHandlers,
  ) {
    session.addEventListener('end', () => this.over());
    session.requestAnimationFrame(this.onFrame);
  }

  // To be called within a tap: browsers begin such a session only then. Throws what failureOf() names.
  static async open(handlers: ArHandlers): Promise<ArCamera> {
    const { XRWebGLLayer, XRWebGLBinding } = window as unknown as XrWindow;
    const xr = xrSystem();
    const gl = document.createElement('canvas').getContext('webgl2', { xrCompatible: true });
    if (!xr || !XRWebGLLayer || !XRWebGLBinding || !gl) {
      throw new DOMException('no augmented reality', 'NotSupportedError');
    }
    const session = await xr.requestSession('immersive-ar', {
      requiredFeatures: ['depth-sensing', 'camera-access'],
      optionalFeatures: ['dom-overlay'],
      domOverlay: { root: document.body }, // so that the page's buttons and dialogs stay where they are
      depthSensing: {
        usagePreference: ['cpu-optimized'], dataFormatPreference: ['luminance-alpha', 'unsigned-short', 'float32'],
      },
    });
    try {
      const layer = new XRWebGLLayer(session, gl);
      session.updateRenderState({ baseLayer: layer });
      const space = await session.requestReferenceSpace('local');
      return new ArCamera(session, space, gl, layer, new XRWebGLBinding(session, gl), new GlPicture(gl), handlers);
    } catch (error) {
      await session.end().catch(() => undefined);
      throw error;
    }
  }

  async end(): Promise<void> {
    if (!this.isOver) {
      await this.session.end().catch(() => undefined);
      this.over();
    }
  }

  // ---- PictureSource ----

  readonly ended = false; // it never comes back by itself: `handlers.ended` tells of it
  async start(): Promise<void> {}

  get running(): boolean {
    return !this.isOver;
  }

  get newest(): number | null {
    return this.picture ? this.count : null;
  }

  // That of the first picture: later ones are brought to it by the computer.
  get description(): CameraDescription | null {
    return this.first && { ...this.first, depth_units_per_metre: kUnitsPerMetre, lens: 'webxr' };
  }

  grey(): GreyPicture | null {
    if (!this.picture) {
      return null;
    }
    const { width, height } = this.picture.camera;
    const scale = kGreySide / Math.max(width, height);
    const [w, h] = [Math.round(width * scale), Math.round(height * scale)];
    this.draw(this.picture);
    Object.assign(this.small, { width: w, height: h });
    const context = this.small.getContext('2d', { willReadFrequently: true });
    context?.drawImage(this.canvas, 0, 0, w, h);
    const drawn = context?.getImageData(0, 0, w, h);
    return drawn ? greyFromRgba(drawn.data, w, h) : null;
  }

  // Pictures without depth make no map, and one of another shape fits none.
  async frame(): Promise<FramePicture | null> {
    const picture = this.picture;
    if (!picture?.depth || picture.isTurned) {
      return null;
    }
    this.draw(picture);
    const [blob, depth] = await Promise.all([
      new Promise<Blob | null>((resolve) => this.canvas.toBlob(resolve, 'image/jpeg', kJpegQuality)),
      encodePng16(picture.depth.width, picture.depth.height, picture.depth.millimetres),
    ]);
    return blob && {
      t: picture.t, color: new Uint8Array(await blob.arrayBuffer()), depth,
      more: {
        version: 2, camera: picture.camera, depth: { width: picture.depth.width, height: picture.depth.height },
        pose: picture.pose,
      },
    };
  }

  private draw({ rgba, camera: { width, height } }: Picture): void {
    Object.assign(this.canvas, { width, height });
    this.canvas.getContext('2d')?.putImageData(new ImageData(rgba, width, height), 0, 0);
  }

  private readonly onFrame = (_time: number, frame: XrFrame): void => {
    if (this.isOver) {
      return;
    }
    this.session.requestAnimationFrame(this.onFrame);
    const { gl } = this;
    gl.bindFramebuffer(gl.FRAMEBUFFER, this.layer.framebuffer); // nothing is drawn over the camera's picture
    gl.clearColor(0, 0, 0, 0);
    gl.clear(gl.COLOR_BUFFER_BIT);
    const t = performance.now();
    if (t - this.takenAt >= kTakeEveryMs) {
      this.take(frame, t);
    }
  };

  private take(frame: XrFrame, t: number): void {
    const pose = frame.getViewerPose(this.space);
    const view = pose?.views[0];
    const texture = view?.camera && this.binding.getCameraImage(view.camera);
    if (!view?.camera || !texture) {
      this.takenAt = t;
      this.handlers.taken({ t, pose: null, hasDepth: false, isTurned: false }); // the phone does not know where it is
      return;
    }
    this.takenAt = t;
    const scale = Math.min(1, kPictureSide / Math.max(view.camera.width, view.camera.height));
    const [width, height] = [Math.round(view.camera.width * scale), Math.round(view.camera.height * scale)];
    const camera = intrinsicsOf(view.projectionMatrix, width, height);
    const depth = this.depthOf(frame, view);
    this.first ??= camera;
    this.count += 1;
    this.picture = {
      t, camera, depth, rgba: this.reader.read(texture, width, height),
      pose: pose?.emulatedPosition ? null : poseOf(view.transform), hasDepth: depth !== null,
      isTurned: width !== this.first.width || height !== this.first.height,
    };
    this.handlers.taken(this.picture);
  }

  private depthOf(frame: XrFrame, view: XrView): DepthGrid | null {
    const told = frame.getDepthInformation(view);
    const grid = told && depthOfView(told, this.session.depthDataFormat);
    return grid && measured(grid) ? grid : null;
  }

  private over(): void {
    if (!this.isOver) {
      this.isOver = true;
      this.picture = null;
      this.handlers.ended();
    }
  }
}
