/** A drift of snow: mounds on a square of level snow, as heights on a grid. */

const SIDE_M = 1;
const DEPTH_M = 0.12;
/** Middle, height and radius in m. */
const MOUNDS = [
  [0, 0, 0.22, 0.26],
  [-0.27, 0.2, 0.06, 0.16],
  [0.28, 0.1, 0.05, 0.18],
] as const;

/** A height field with the keys of scene files, of some steps along each side; heights in m above level snow. */
export function drift(count: number): Record<string, unknown> {
  const place = (step: number) => SIDE_M * (step / count - 0.5);
  const steps = Array.from({ length: count + 1 }, (_, step) => step);
  // Rows run from far to near.
  const heights = steps.map((row) =>
    steps.map((column) => {
      const [x, y] = [place(column), -place(row)];
      const height = MOUNDS.reduce(
        (sum, [middleX, middleY, top, radius]) =>
          sum + top * Math.exp(-((x - middleX) ** 2 + (y - middleY) ** 2) / radius ** 2),
        0,
      );
      return Number(height.toFixed(4));
    }),
  );
  return { shape: "heights", size: [SIDE_M, SIDE_M, 1], bottom: -DEPTH_M, heights };
}
