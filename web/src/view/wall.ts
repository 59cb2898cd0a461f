/**
 * A piece of the wall of an igloo: three courses of blocks on a cylinder about the vertical. The edges of the blocks
 * are rounded towards both faces, so that the wall is thinnest at the seams.
 */

import type { Triangles } from "./triangles";

const RADIUS_M = 0.8;
const WIDTH_M = 0.7;
const HEIGHT_M = 0.44;
const WALL_M = 0.24;
const COURSES = 3;
const BLOCK_WIDTH_M = 0.28;
const SEAM_DEPTH_M = 0.03;
const SEAM_WIDTH_M = 0.05;

/** How much thinner either half of the wall is at a place, in m; `along` runs to the right, `up` from the ground. */
function groove(along: number, up: number): number {
  const courseHeight = HEIGHT_M / COURSES;
  const course = Math.min(Math.floor(up / courseHeight), COURSES - 1);
  const shift = course % 2 === 0 ? 0 : 0.5;
  const inCourse = up - course * courseHeight;
  const inBlock = (along / BLOCK_WIDTH_M + shift) * BLOCK_WIDTH_M;
  const fromJoint = Math.abs(inBlock - BLOCK_WIDTH_M * Math.round(inBlock / BLOCK_WIDTH_M));
  const below = course === 0 ? Infinity : inCourse;
  const above = course === COURSES - 1 ? Infinity : courseHeight - inCourse;
  const rounded = (distance: number) => Math.cos(0.5 * Math.PI * Math.min(distance / SEAM_WIDTH_M, 1)) ** 2;
  return SEAM_DEPTH_M * Math.max(rounded(fromJoint), rounded(Math.min(below, above)));
}

/** The wall with some columns of vertices for half a block and some rows for a course, so that they meet the seams. */
export function wall(columnsOfHalfBlock: number, rowsOfCourse: number): Triangles {
  const columns = Math.round((2 * columnsOfHalfBlock * WIDTH_M) / BLOCK_WIDTH_M);
  const rows = rowsOfCourse * COURSES;
  const positions: number[] = [];
  const triangles: number[] = [];
  const perFace = (columns + 1) * (rows + 1);
  for (const side of [-1, 1]) {
    for (let row = 0; row <= rows; row++) {
      for (let column = 0; column <= columns; column++) {
        const along = WIDTH_M * (column / columns - 0.5);
        const up = (HEIGHT_M * row) / rows;
        // The middle of the piece is at the origin, and the outside of the igloo towards the camera.
        const radius = RADIUS_M + side * (0.5 * WALL_M - groove(along, up));
        const angle = along / RADIUS_M;
        positions.push(radius * Math.sin(angle), RADIUS_M - radius * Math.cos(angle), up);
      }
    }
  }
  const at = (face: number, row: number, column: number) => face * perFace + row * (columns + 1) + column;
  const quad = (a: number, b: number, c: number, d: number) => triangles.push(a, b, c, a, c, d);
  const [INNER, OUTER] = [0, 1];
  for (let row = 0; row < rows; row++) {
    for (let column = 0; column < columns; column++) {
      const corners = (face: number) =>
        [at(face, row, column), at(face, row, column + 1), at(face, row + 1, column + 1), at(face, row + 1, column)] as
          const;
      const [a, b, c, d] = corners(OUTER);
      quad(a, b, c, d);
      const [e, f, g, h] = corners(INNER);
      quad(h, g, f, e);
    }
  }
  for (let column = 0; column < columns; column++) {
    quad(at(INNER, 0, column), at(INNER, 0, column + 1), at(OUTER, 0, column + 1), at(OUTER, 0, column));
    quad(at(OUTER, rows, column), at(OUTER, rows, column + 1), at(INNER, rows, column + 1), at(INNER, rows, column));
  }
  for (let row = 0; row < rows; row++) {
    quad(at(INNER, row, 0), at(OUTER, row, 0), at(OUTER, row + 1, 0), at(INNER, row + 1, 0));
    quad(at(OUTER, row, columns), at(INNER, row, columns), at(INNER, row + 1, columns), at(OUTER, row + 1, columns));
  }
  return { positions, triangles };
}
