/** Keeps all files of the page, so that it works offline after the first visit. */

export {};

const worker = self as unknown as ServiceWorkerGlobalScope;
const PREFIX = "snowblue-";
const CACHE = `${PREFIX}${BUILD}`;
/** The addresses of the page. */
const PAGE = ["./", "index.html"].map((name) => new URL(name, worker.location.href).href);

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
  const open = await worker.clients.matchAll({ type: "window", includeUncontrolled: true });
  // One address is enough for both, and that of the visitor is not sent again.
  const page = PAGE.find((address) => open.some(({ url }) => withoutEnd(url) === address)) ?? PAGE[0]!;
  // The server says of files that the page has loaded whether they are still the same, and does not send them again.
  await cache.addAll([page, ...FILES].map((file) => new Request(file, { cache: "no-cache" })));
}

async function forget(): Promise<void> {
  const names = await caches.keys();
  const old = names.filter((name) => name.startsWith(PREFIX) && name !== CACHE);
  await Promise.all(old.map((name) => caches.delete(name)));
}

async function answer(request: Request): Promise<Response> {
  const cache = await caches.open(CACHE);
  for (const address of PAGE.includes(withoutEnd(request.url)) ? PAGE : [request]) {
    const kept = await cache.match(address);
    if (kept !== undefined) return kept;
  }
  return fetch(request);
}

/** An address without its query and fragment. */
function withoutEnd(url: string): string {
  return url.replace(/[?#].*/s, "");
}
