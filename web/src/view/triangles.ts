/** Triangles, counter-clockwise seen from outside, in metres with z upwards. */
export interface Triangles {
  positions: Float32Array;
  triangles: Uint32Array;
}
