/** Keeps all files of the page, so that it works offline after the first visit. */

export {};

const worker = self as unknown as ServiceWorkerGlobalScope;
const PREFIX = "snowblue-";
const CACHE = `${PREFIX}${BUILD}`;

worker.addEventListener("install", (event) => {
  event.waitUntil(keep());
});

worker.addEventListener("activate", (event) => {
  event.waitUntil(forget().then(() => worker.clients.claim()));
});

worker.addEventListener("fetch", (event) => {
  if (event.request.method === "GET" && new URL(event.request.url).origin === worker.location.origin) {
    event.respondWith(answer(event.request));
  }
});

async function keep(): Promise<void> {
  const cache = await caches.open(CACHE);
  // The server says of files that the page has loaded whether they are still the same, and does not send them again.
  await cache.addAll(["./", ...FILES].map((file) => new Request(file, { cache: "no-cache" })));
}

async function forget(): Promise<void> {
  const names = await caches.keys();
  const old = names.filter((name) => name.startsWith(PREFIX) && name !== CACHE);
  await Promise.all(old.map((name) => caches.delete(name)));
}

async function answer(request: Request): Promise<Response> {
  const cache = await caches.open(CACHE);
  return (await cache.match(request, { ignoreSearch: request.mode === "navigate" })) ?? fetch(request);
}
