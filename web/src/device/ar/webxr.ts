// What this page uses of WebXR, with depth sensing, raw camera access and DOM overlays. TypeScript's own library has none
// of it.

export interface XrRigidTransform {
  position: { x: number; y: number; z: number };
  orientation: { x: number; y: number; z: number; w: number };
  matrix: Float32Array; // column by column
}

export interface XrCamera {
  width: number;
  height: number;
}

export interface XrView {
  projectionMatrix: Float32Array; // column by column
  transform: XrRigidTransform; // from the view to the reference space: x right, y up, z back
  camera?: XrCamera | null;
}

export interface XrViewerPose {
  views: readonly XrView[];
  emulatedPosition: boolean; // the position is a guess
}

export interface XrDepthInformation {
  width: number;
  height: number;
  data: ArrayBuffer;
  rawValueToMeters: number;
  normDepthBufferFromNormView: { matrix: Float32Array };
}

export type XrReferenceSpace = object;

export interface XrFrame {
  getViewerPose(space: XrReferenceSpace): XrViewerPose | null | undefined;
  getDepthInformation(view: XrView): XrDepthInformation | null | undefined;
}

export interface XrSession extends EventTarget {
  readonly depthDataFormat?: 'luminance-alpha' | 'unsigned-short' | 'float32';
  requestReferenceSpace(kind: 'local'): Promise<XrReferenceSpace>;
  requestAnimationFrame(run: (time: number, frame: XrFrame) => void): number;
  updateRenderState(state: { baseLayer: object }): void;
  end(): Promise<void>;
}

export interface XrSystem {
  isSessionSupported(mode: 'immersive-ar'): Promise<boolean>;
  requestSession(mode: 'immersive-ar', init: object): Promise<XrSession>;
}

interface XrLayer {
  framebuffer: WebGLFramebuffer | null;
}

export interface XrBinding {
  getCameraImage(camera: XrCamera): WebGLTexture | null;
}

export interface XrWindow {
  XRWebGLLayer?: new (session: XrSession, gl: WebGL2RenderingContext) => XrLayer;
  XRWebGLBinding?: new (session: XrSession, gl: WebGL2RenderingContext) => XrBinding;
}

export function xrSystem(): XrSystem | null {
  return (navigator as unknown as { xr?: XrSystem }).xr ?? null;
}
