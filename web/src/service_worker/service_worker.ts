// Keeps the shell of the phone's page (its files, nothing of the home), so that it opens, and can say that there is
// no connection, when the computer is not reached. What the computer serves comes first, wherever it is reached.
declare const SHELL_VERSION: string; // put in by the build
declare const SHELL_FILES: string[];
declare const self: ServiceWorkerGlobalScope;

const kCache = `roomwise-shell-${SHELL_VERSION}`;
const kPages: Record<string, string> = { '/device': '/device.html', '/pair': '/pair.html' };

self.addEventListener('install', (event) => {
  event.waitUntil(
    caches
      .open(kCache)
      .then((cache) => cache.addAll(SHELL_FILES))
      .then(() => self.skipWaiting()),
  );
});

self.addEventListener('activate', (event) => {
  event.waitUntil(
    caches
      .keys()
      .then((names) => Promise.all(names.filter((name) => name !== kCache).map((name) => caches.delete(name))))
      .then(() => self.clients.claim()),
  );
});

self.addEventListener('fetch', (event) => {
  const { pathname, origin } = new URL(event.request.url);
  const file = kPages[pathname] ?? pathname;
  if (event.request.method !== 'GET' || origin !== self.location.origin || !SHELL_FILES.includes(file)) {
    return; // the network's alone
  }
  event.respondWith(
    fetch(event.request).catch(async () => {
      const kept = await caches.match(file, { cacheName: kCache });
      return kept ?? Response.error();
    }),
  );
});

export {};
