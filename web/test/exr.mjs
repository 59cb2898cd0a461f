// Reads the pictures that the command writes: OpenEXR of 32-bit floats in lines, compressed by zip or not at all.

import assert from "node:assert/strict";
import { inflateSync } from "node:zlib";

const FLOAT = 2;
/** Lines of a block by the number of the compression: none, and zip of sixteen lines. */
const LINES = { 0: 1, 3: 16 };

/** The picture as a function from column, row and channel to a value. */
export function readExr(file) {
  const { attributes, at } = header(file);
  const { width, height } = windowOf(attributes.dataWindow);
  const channels = channelsOf(attributes.channels);
  const lines = LINES[attributes.compression[0]];
  const rows = [];
  for (let block = 0; block < Math.ceil(height / lines); block++) {
    const start = Number(file.readBigUInt64LE(at + 8 * block));
    const packed = file.subarray(start + 8, start + 8 + file.readInt32LE(start + 4));
    const count = Math.min(lines, height - rows.length);
    const bytes = unpacked(packed, 4 * width * channels.length * count);
    for (let row = 0; row < count; row++) rows.push(bytes.subarray(4 * width * channels.length * row));
  }
  return (column, row, channel) => rows[row].readFloatLE(4 * (channels.indexOf(channel) * width + column));
}

function header(file) {
  const attributes = {};
  let at = 8;
  const text = () => {
    const end = file.indexOf(0, at);
    const found = file.toString("latin1", at, end);
    at = end + 1;
    return found;
  };
  for (let name = text(); name !== ""; name = text()) {
    text();
    const size = file.readInt32LE(at);
    attributes[name] = file.subarray(at + 4, at + 4 + size);
    at += 4 + size;
  }
  return { attributes, at };
}

function windowOf(bytes) {
  const [left, top, right, bottom] = [0, 4, 8, 12].map((place) => bytes.readInt32LE(place));
  return { width: right - left + 1, height: bottom - top + 1 };
}

function channelsOf(bytes) {
  const names = [];
  for (let at = 0; bytes[at] !== 0;) {
    const end = bytes.indexOf(0, at);
    assert.equal(bytes.readInt32LE(end + 1), FLOAT);
    names.push(bytes.toString("latin1", at, end));
    at = end + 17;
  }
  return names;
}

/** Undoes zip, the differences of neighbours, and the separation of even from odd bytes. */
function unpacked(packed, size) {
  if (packed.length === size) return packed;
  const bytes = inflateSync(packed);
  for (let at = 1; at < bytes.length; at++) bytes[at] = bytes[at - 1] + bytes[at] - 128;
  const half = Math.ceil(bytes.length / 2);
  return Buffer.from(bytes.map((_, at) => bytes[(at >> 1) + (at % 2) * half]));
}
