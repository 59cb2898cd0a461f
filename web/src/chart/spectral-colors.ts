/** Colours of single wavelengths, for the strip below an axis. */

interface Lobe {
  height: number;
  middle_nm: number;
  below: number;
  above: number;
}

const lobe = (height: number, middle_nm: number, below: number, above: number): Lobe =>
  ({ height, middle_nm, below, above });

/** Fit of the CIE 1931 observer by Wyman, Sloan & Shirley 2013, Journal of Computer Graphics Techniques 2(2). */
const OBSERVER: readonly (readonly Lobe[])[] = [
  [lobe(0.362, 442, 0.0624, 0.0374), lobe(1.056, 599.8, 0.0264, 0.0323), lobe(-0.065, 501.1, 0.049, 0.0382)],
  [lobe(0.821, 568.8, 0.0213, 0.0247), lobe(0.286, 530.9, 0.0613, 0.0322)],
  [lobe(1.217, 437, 0.0845, 0.0278), lobe(0.681, 459, 0.0385, 0.0725)],
];
const TO_RGB = [
  [3.2406, -1.5372, -0.4986],
  [-0.9689, 1.8758, 0.0415],
  [0.0557, -0.204, 1.057],
];
/** White added to each colour, which brings most into the gamut. */
const WHITE = 0.12;

/** The colour of a wavelength in CSS, dim at the ends of the visible range. */
export function spectralColor(wavelength_nm: number): string {
  const xyz = OBSERVER.map((lobes) => lobes.reduce((sum, one) => sum + height(one, wavelength_nm), 0));
  const encoded = TO_RGB.map((row) => {
    const linear = row.reduce((sum, factor, index) => sum + factor * xyz[index]!, 0);
    return Math.round(255 * Math.min(1, Math.max(0, 0.75 * linear + WHITE * xyz[1]!)) ** (1 / 2.2));
  });
  return `rgb(${encoded.join(" ")})`;
}

function height({ height, middle_nm, below, above }: Lobe, wavelength_nm: number): number {
  const way = (wavelength_nm - middle_nm) * (wavelength_nm < middle_nm ? below : above);
  return height * Math.exp(-0.5 * way * way);
}
