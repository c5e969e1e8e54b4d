// Holds the screen on, and the camera running, while the page is in sight.
import type { Camera } from './camera';

export function keepAwake(camera: Camera, cameraLost: () => void): void {
  const inSight = async (): Promise<void> => {
    if (document.visibilityState !== 'visible') {
      return;
    }
    // Not everywhere there, and refused when the battery is low: then the screen goes off as it is set.
    await navigator.wakeLock?.request('screen').catch(() => undefined);
    if (started && !camera.running) {
      await camera.start().catch(cameraLost); // iOS ends it when the page goes out of sight
    }
  };
  const started = camera.running;
  document.addEventListener('visibilitychange', () => void inSight());
  void inSight();
}
