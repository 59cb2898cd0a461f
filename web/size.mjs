// Prints the size of each file of a page, and fails if all together have more than a page may have:
// `node web/size.mjs web/dist`. scripts/build-web makes that page; the one of tests is several times as large.

import { readFileSync, readdirSync } from "node:fs";
import { join } from "node:path";
import { brotliCompressSync, gzipSync } from "node:zlib";

const [, , DIST] = process.argv;
/** Greatest size of all files together, brotli-compressed. */
const MOST_BYTES = 1.34 * (1 << 20);

const sizes = readdirSync(DIST).sort().map((file) => {
  const bytes = readFileSync(join(DIST, file));
  return { file, plain: bytes.length, gzip: gzipSync(bytes).length, brotli: brotliCompressSync(bytes).length };
});
const sum = (key) => sizes.reduce((total, size) => total + size[key], 0);
sizes.push({ file: "total", plain: sum("plain"), gzip: sum("gzip"), brotli: sum("brotli") });
for (const { file, plain, gzip, brotli } of sizes) {
  const columns = [plain, gzip, brotli].map((size) => String(size).padStart(10));
  console.log(`${file.padEnd(26)}${columns.join("")}`);
}
const total = sizes.at(-1).brotli;
if (total > MOST_BYTES) {
  console.error(`The page has ${total} bytes in brotli, but may have ${MOST_BYTES}.`);
  process.exit(1);
}
