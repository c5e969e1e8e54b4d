// The phone's camera: pictures as JPEG for the computer, small grey copies to look after the camera itself.
import type { CameraDescription } from './protocol';
import { greyFromRgba, type GreyPicture } from './picture_quality';
import { kGreySide, kPictureSide, type FramePicture, type PictureSource } from './picture_source';

const kJpegQuality = 0.8;
const kMaxLensName = 50; // characters, of at most 200 bytes

export type CameraFailure = 'refused' | 'failed';

export class Camera implements PictureSource {
  private stream: MediaStream | null = null;
  private starting: Promise<CameraFailure | null> | null = null;
  private wasOpen = false;
  private isHeld = false; // somebody else on this page needs the camera
  private stops = 0; // a stream that was asked for before the last is stopped when it comes
  private readonly picture = document.createElement('canvas');
  private readonly small = document.createElement('canvas');

  private shown = 0; // pictures, where the browser tells of each

  constructor(private readonly video: HTMLVideoElement) {
    if ('requestVideoFrameCallback' in video) {
      const count = (): void => {
        this.shown += 1;
        video.requestVideoFrameCallback(count);
      };
      video.requestVideoFrameCallback(count);
    }
  }

  // Asks for leave where it was not given. What stands against it: no leave, or no camera that works.
  async start(): Promise<CameraFailure | null> {
    if (this.isHeld) {
      return null;
    }
    this.starting ??= this.tryToOpen();
    return this.starting;
  }

  private async tryToOpen(): Promise<CameraFailure | null> {
    this.stop();
    const mine = this.stops;
    try {
      await this.open(() => mine === this.stops);
      return null;
    } catch (error) {
      const isRefused = error instanceof DOMException && error.name === 'NotAllowedError';
      return mine !== this.stops ? null : isRefused ? 'refused' : 'failed';
    } finally {
      if (mine === this.stops) {
        this.starting = null;
      }
    }
  }

  private async open(isWanted: () => boolean): Promise<void> {
    const stream = await navigator.mediaDevices.getUserMedia({
      audio: false,
      video: { facingMode: { ideal: 'environment' }, width: { ideal: 640 }, height: { ideal: 480 } },
    });
    if (!isWanted()) {
      stream.getTracks().forEach((track) => track.stop());
      return;
    }
    this.stream = stream;
    this.video.srcObject = stream;
    await this.video.play();
    this.wasOpen = true;
  }

  stop(): void {
    this.stops += 1;
    this.starting = null; // whoever wants it again has to ask for it anew
    this.stream?.getTracks().forEach((track) => track.stop());
    this.stream = null;
  }

  // Leaves the phone's camera to others until it is let go.
  hold(): void {
    this.isHeld = true;
    this.stop();
  }

  letGo(): Promise<CameraFailure | null> {
    this.isHeld = false;
    return this.start();
  }

  get running(): boolean {
    return this.track !== null;
  }

  // It ran and runs no more: somebody else took it, or the leave was taken back.
  get ended(): boolean {
    return this.wasOpen && !this.isHeld && !this.running;
  }

  // Changes with every picture; null while none come. A track is muted while a call or another app has the camera.
  get newest(): number | null {
    if (!this.track || this.track.muted || this.video.videoWidth === 0) {
      return null;
    }
    // The clock of a stream runs on without pictures. Chromium counts them; others count none, but tell of each while the page is seen.
    const counted = this.video.getVideoPlaybackQuality().totalVideoFrames || (document.hidden ? 0 : this.shown);
    return counted || this.video.currentTime;
  }

  private get track(): MediaStreamTrack | null {
    return this.stream?.getVideoTracks().find((track) => track.readyState === 'live') ?? null;
  }

  private get hasPictures(): boolean {
    return this.running && this.video.videoWidth > 0;
  }

  // Of the pictures that are sent; null while there are none.
  get description(): CameraDescription | null {
    if (!this.hasPictures) {
      return null;
    }
    const label = [...(this.track?.label ?? '')].slice(0, kMaxLensName).join('');
    return { ...this.sizeWithin(kPictureSide), ...(label && { lens: label }) };
  }

  grey(): GreyPicture | null {
    const drawn = this.draw(this.small, kGreySide);
    if (!drawn) {
      return null;
    }
    const { width, height } = this.small;
    return greyFromRgba(drawn.getImageData(0, 0, width, height).data, width, height);
  }

  async frame(): Promise<FramePicture | null> {
    if (!this.draw(this.picture, kPictureSide)) {
      return null;
    }
    const blob = await new Promise<Blob | null>((resolve) => {
      this.picture.toBlob(resolve, 'image/jpeg', kJpegQuality);
    });
    return blob && { t: null, color: new Uint8Array(await blob.arrayBuffer()) };
  }

  private draw(canvas: HTMLCanvasElement, longest: number): CanvasRenderingContext2D | null {
    const context = canvas.getContext('2d', { willReadFrequently: true });
    if (!context || !this.hasPictures) {
      return null;
    }
    const { width, height } = this.sizeWithin(longest);
    if (canvas.width !== width || canvas.height !== height) {
      canvas.width = width;
      canvas.height = height;
    }
    context.drawImage(this.video, 0, 0, width, height);
    return context;
  }

  private sizeWithin(longest: number): { width: number; height: number } {
    const { videoWidth, videoHeight } = this.video;
    const scale = Math.min(1, longest / Math.max(videoWidth, videoHeight));
    return { width: Math.round(videoWidth * scale), height: Math.round(videoHeight * scale) };
  }
}
