/**
 * Random walks through a layer of snow: light that is scattered equally in all directions after each transport
 * mean free path, as it is after many scatterings by grains (Kokhanovsky & Zege 2004).
 */

/** A walk from the upper surface, by x and depth in layers' thicknesses. */
export interface Walk {
  places: [number, number][];
  /** Length from the start to each place, in thicknesses. */
  lengths: number[];
  isTransmitted: boolean;
}

const SEED = 12;
/** Beyond the surface, for the eye, in thicknesses. */
const OUT = 0.22;
/** Only against walks that absorption would end. */
const MOST_STEPS = 20_000;
const HALVINGS = 40;

/**
 * Mean free path l in thicknesses d of a layer that absorbs little, by its transmittance for a beam at right angles:
 * T = (1 + q) l/(d + 2 q l), with the extrapolation length q = 0.7104.
 */
export function freePath(transmittance: number): number {
  const q = 0.7104;
  return transmittance / (1 + q - 2 * q * transmittance);
}

export function walks(count: number, free_path: number): Walk[] {
  const random = generator(SEED);
  return Array.from({ length: count }, () => walk(free_path, random));
}

function walk(free_path: number, random: () => number): Walk {
  const places: [number, number][] = [[0, 0]];
  const lengths = [0];
  let [x, z, length] = [0, 0, 0];
  let [across, down] = [0, 1];
  for (let step = 0; step < MOST_STEPS; step++) {
    const path = -free_path * Math.log(1 - random());
    const beyond = down < 0 ? z + path * down < 0 : z + path * down > 1;
    const inside = beyond ? (down < 0 ? z / -down : (1 - z) / down) : path;
    length += inside;
    [x, z] = [x + inside * across, z + inside * down];
    places.push([x, z]);
    lengths.push(length);
    if (beyond) {
      places.push([x + OUT * across, z + OUT * down]);
      lengths.push(length);
      return { places, lengths, isTransmitted: down > 0 };
    }
    // Of a direction in space, the parts in the plane of the drawing.
    down = 2 * random() - 1;
    across = Math.sqrt(1 - down * down) * Math.cos(2 * Math.PI * random());
  }
  return { places, lengths, isTransmitted: false };
}

export function transmitted(some: readonly Walk[]): Walk[] {
  return some.filter(({ isTransmitted }) => isTransmitted);
}

/**
 * The factor of lengths by which light is absorbed along some walks until a part is left: ⟨exp(−factor × length)⟩ is
 * the part.
 */
export function absorbing(some: readonly Walk[], part: number): number {
  const rest = (factor: number) => meanOf(some, (length) => Math.exp(-factor * length));
  let [low, high] = [0, 1];
  while (rest(high) > part) high *= 2;
  for (let halving = 0; halving < HALVINGS; halving++) {
    const middle = 0.5 * (low + high);
    if (rest(middle) > part) low = middle;
    else high = middle;
  }
  return high;
}

/** Mean of a function of the length. */
export function meanOf(some: readonly Walk[], of: (length: number) => number): number {
  return some.reduce((sum, { lengths }) => sum + of(lengths[lengths.length - 1]!), 0) / some.length;
}

/** Numbers from 0 to 1, the same for the same seed (mulberry32). */
function generator(seed: number): () => number {
  let state = seed;
  return () => {
    state = (state + 0x6d2b79f5) | 0;
    let value = Math.imul(state ^ (state >>> 15), 1 | state);
    value = (value + Math.imul(value ^ (value >>> 7), 61 | value)) ^ value;
    return ((value ^ (value >>> 14)) >>> 0) / 4_294_967_296;
  };
}
