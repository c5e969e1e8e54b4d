// Keeps the shell of the phone's page (its files, nothing of the home), so that it opens, and can say that there is
// no connection, when the computer is not reached. What the computer serves comes first, wherever it is reached.
declare const SHELL_VERSION: string; // put in by the build
declare const SHELL_FILES: string[]; // paths of the home, which its own address stands before
declare const self: ServiceWorkerGlobalScope;

// Of one home among many it answers for that home's address alone, and its files are kept apart.
const kBase = new URL(self.registration.scope).pathname.replace(/\/$/, '');
const kKind = `roomwise-shell${kBase}-`;
const kCache = kKind + SHELL_VERSION;
const kPages: Record<string, string> = { '/device': '/device.html', '/pair': '/pair.html' };

self.addEventListener('install', (event) => {
  event.waitUntil(
    caches
      .open(kCache)
      .then((cache) => cache.addAll(SHELL_FILES.map((file) => kBase + file)))
      .then(() => self.skipWaiting()),
  );
});

self.addEventListener('activate', (event) => {
  event.waitUntil(
    caches
      .keys()
      .then((names) => Promise.all(names.filter((name) => name.startsWith(kKind) && name !== kCache).map((name) => caches.delete(name))))
      .then(() => self.clients.claim()),
  );
});

self.addEventListener('fetch', (event) => {
  const { pathname, origin } = new URL(event.request.url);
  const path = pathname.startsWith(`${kBase}/`) ? pathname.slice(kBase.length) : '';
  const file = kPages[path] ?? path;
  if (event.request.method !== 'GET' || origin !== self.location.origin || !SHELL_FILES.includes(file)) {
    return; // the network's alone
  }
  event.respondWith(
    fetch(event.request).catch(async () => {
      const kept = await caches.match(kBase + file, { cacheName: kCache });
      return kept ?? Response.error();
    }),
  );
});

export {};
