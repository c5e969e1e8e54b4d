// The session over the browser's own socket and timers.
import { at } from './base';
import { kSubprotocol, type FromComputer, type Hello } from './protocol';
import { Session, type Socket } from './session';

export interface SessionHandlers {
  hello: () => Hello;
  onMessage: (message: FromComputer) => void;
  onOnline: () => void;
  onOffline: () => void;
}

export function browserSession(handlers: SessionHandlers): Session {
  const scheme = location.protocol === 'https:' ? 'wss' : 'ws';
  const address = `${scheme}://${location.host}${at('/api/socket')}`;
  const session = new Session({
    ...handlers,
    openSocket: () => new WebSocket(address, kSubprotocol) as Socket,
    setTimer: (run, ms) => window.setTimeout(run, ms),
    clearTimer: (timer) => window.clearTimeout(timer),
  });
  // Waits are cut short when there is reason to hope.
  const tryNow = (): void => {
    if (!session.online && document.visibilityState === 'visible') {
      session.connect();
    }
  };
  window.addEventListener('online', tryNow);
  document.addEventListener('visibilitychange', tryNow);
  return session;
}
