// A cube of 30 cm as files, made here.

const SIDE = 0.3;
const CORNERS = [0, 1, 2, 3, 4, 5, 6, 7].map((corner) => [corner & 1, (corner >> 1) & 1, corner >> 2].map((at) =>
  SIDE * (at - 0.5)));
/** Counter-clockwise from outside. */
const TRIANGLES = [
  [0, 2, 3], [0, 3, 1], [4, 5, 7], [4, 7, 6], [0, 1, 5], [0, 5, 4],
  [2, 6, 7], [2, 7, 3], [0, 4, 6], [0, 6, 2], [1, 3, 7], [1, 7, 5],
];

export function cubePly() {
  return ply(TRIANGLES);
}

/** Without one of its triangles. */
export function openPly() {
  return ply(TRIANGLES.slice(1));
}

/** Triangles that share no vertices, inside out. */
export function soupPly() {
  const corners = TRIANGLES.flatMap(([a, b, c]) => [c, b, a]).map((corner) => CORNERS[corner]);
  return ply(TRIANGLES.map((_, number) => [3 * number, 3 * number + 1, 3 * number + 2]), corners);
}

function ply(triangles, corners = CORNERS) {
  return [
    "ply", "format ascii 1.0",
    `element vertex ${corners.length}`, ...["x", "y", "z"].map((axis) => `property float ${axis}`),
    `element face ${triangles.length}`, "property list uchar int vertex_indices", "end_header",
    ...corners.map((corner) => corner.join(" ")), ...triangles.map((face) => `${face.length} ${face.join(" ")}`), "",
  ].join("\n");
}

/** A prism whose ends are pentagons, 30 cm high. */
export function prismPly() {
  const ring = [0, 1, 2, 3, 4].map((corner) => (2 * Math.PI * corner) / 5);
  const corners = [0, SIDE].flatMap((z) => ring.map((angle) => [0.15 * Math.cos(angle), 0.15 * Math.sin(angle), z]));
  const sides = [0, 1, 2, 3, 4].map((at) => [at, (at + 1) % 5, 5 + (at + 1) % 5, 5 + at]);
  return ply([[4, 3, 2, 1, 0], [5, 6, 7, 8, 9], ...sides], corners);
}

/** A cube of 300, as programs for millimetres write it. */
export function cubeStl() {
  const corners = CORNERS.map((corner) => corner.map((value) => 1000 * value));
  const facet = (triangle) => ["facet normal 0 0 0", "outer loop",
    ...triangle.map((corner) => `vertex ${corners[corner].join(" ")}`), "endloop", "endfacet"];
  return ["solid cube", ...TRIANGLES.flatMap(facet), "endsolid cube", ""].join("\n");
}

export function cubeObj() {
  return [...CORNERS.map((corner) => `v ${corner.join(" ")}`),
    ...TRIANGLES.map((triangle) => `f ${triangle.map((corner) => corner + 1).join(" ")}`), ""].join("\n");
}

/** A ball of so many triangles that no link holds it. */
export function ballObj(around = 120, rings = 60) {
  const at = (ring, place) => (ring === 0 ? 1 : ring === rings ? 2 + (rings - 1) * around :
    2 + (ring - 1) * around + (place % around));
  const rows = ["v 0 0 0.15"];
  for (let ring = 1; ring < rings; ring++) {
    for (let place = 0; place < around; place++) {
      const [polar, azimuth] = [(Math.PI * ring) / rings, (2 * Math.PI * place) / around];
      rows.push(`v ${0.15 * Math.sin(polar) * Math.cos(azimuth)} ${0.15 * Math.sin(polar) * Math.sin(azimuth)} ${
        0.15 * Math.cos(polar)}`);
    }
  }
  rows.push("v 0 0 -0.15");
  for (let ring = 0; ring < rings; ring++) {
    for (let place = 0; place < around; place++) {
      const corners = [at(ring, place), at(ring + 1, place), at(ring + 1, place + 1), at(ring, place + 1)];
      rows.push(`f ${[...new Set(corners)].join(" ")}`);
    }
  }
  return `${rows.join("\n")}\n`;
}

export function cubeGlb() {
  const positions = Buffer.from(Float32Array.from(CORNERS.flat()).buffer);
  const indices = Buffer.from(Uint16Array.from(TRIANGLES.flat()).buffer);
  const [least, greatest] = [-SIDE / 2, SIDE / 2].map((value) => [value, value, value]);
  const json = Buffer.from(JSON.stringify({
    asset: { version: "2.0" },
    scene: 0,
    scenes: [{ nodes: [0] }],
    nodes: [{ mesh: 0 }],
    meshes: [{ primitives: [{ attributes: { POSITION: 0 }, indices: 1 }] }],
    accessors: [
      { bufferView: 0, componentType: 5126, count: CORNERS.length, type: "VEC3", min: least, max: greatest },
      { bufferView: 1, componentType: 5123, count: indices.length / 2, type: "SCALAR" },
    ],
    bufferViews: [
      { buffer: 0, byteLength: positions.length },
      { buffer: 0, byteOffset: positions.length, byteLength: indices.length },
    ],
    buffers: [{ byteLength: positions.length + indices.length }],
  }));
  const padded = Buffer.concat([json, Buffer.alloc((4 - (json.length % 4)) % 4, " ")]);
  const binary = Buffer.concat([positions, indices]);
  const words = (...values) => Buffer.from(Uint32Array.from(values).buffer);
  return Buffer.concat([
    Buffer.from("glTF"), words(2, 28 + padded.length + binary.length),
    words(padded.length), Buffer.from("JSON"), padded, words(binary.length), Buffer.from("BIN\0"), binary,
  ]);
}
