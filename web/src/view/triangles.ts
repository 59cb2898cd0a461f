/** Coordinates of vertices, and vertices of triangles, counter-clockwise from outside. */
export interface Triangles {
  positions: number[];
  triangles: number[];
}
