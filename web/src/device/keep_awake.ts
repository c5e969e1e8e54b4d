// Holds the screen on, and the camera running, while the page is in sight.
import type { Camera, CameraFailure } from '../shared/camera';

export function keepAwake(camera: Camera, cameraFailed: (why: CameraFailure) => void): void {
  const inSight = async (): Promise<void> => {
    if (document.visibilityState !== 'visible') {
      return;
    }
    // Not everywhere there, and refused when the battery is low: then the screen goes off as it is set.
    await navigator.wakeLock?.request('screen').catch(() => undefined);
    if (started && camera.ended) {
      const failure = await camera.start(); // iOS ends it when the page goes out of sight
      if (failure) {
        cameraFailed(failure);
      }
    }
  };
  const started = camera.running;
  document.addEventListener('visibilitychange', () => void inSight());
  void inSight();
}
