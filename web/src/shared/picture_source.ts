// Where the phone's pictures come from: its camera, or a session of augmented reality.
import type { CameraDescription, FrameAdditions } from './protocol';
import type { GreyPicture } from './picture_quality';

export const kPictureSide = 640; // longest, pixels
export const kGreySide = 120;

export interface FramePicture {
  t: number | null; // when it was taken; null: now
  color: Uint8Array; // JPEG
  depth?: Uint8Array; // 16-bit PNG
  more?: FrameAdditions;
}

export interface PictureSource {
  readonly running: boolean;
  readonly ended: boolean; // it ran and runs no more; start() may bring it back
  readonly newest: number | null; // changes with every picture; null while none come
  readonly description: CameraDescription | null; // of the pictures that are sent; null while there are none
  grey(): GreyPicture | null;
  frame(): Promise<FramePicture | null>;
  start(): Promise<unknown>;
}
