//! Spectra as colours: the wavelengths that are summed, and the columns and cells that tell a colour.

use snowblue_color::{Colorimeter, Illuminant, Lab, LinearRgb, Srgb8};

use crate::report::Cell;

/// The paper's three sample wavelengths, in nm.
const THREE_SAMPLES_NM: [f64; 3] = [455.0, 551.0, 608.0];

/// Columns of colours.
pub(crate) const COLUMNS: [&str; 13] = [
    "thickness_cm",
    "angle_deg",
    "illuminant",
    "X",
    "Y",
    "Z",
    "L",
    "a",
    "b",
    "r_linear",
    "g_linear",
    "b_linear",
    "hex",
];

/// Columns of false colours, which no eye sees: they have no illuminant, XYZ or CIELAB.
pub(crate) const FALSE_COLUMNS: [&str; 6] = ["thickness_cm", "angle_deg", "r_linear", "g_linear", "b_linear", "hex"];

/// The wavelengths of 31 or 3 samples, in nm.
pub(crate) fn wavelengths_nm(samples: &str) -> Vec<f64> {
    match samples {
        "3" => THREE_SAMPLES_NM.to_vec(),
        _ => (0..31).map(|step| 400.0 + 10.0 * f64::from(step)).collect(),
    }
}

/// A colour as it is, and the cells of its row but the last, hex, which waits for an exposure.
pub(crate) struct Colored {
    pub(crate) light: LinearRgb,
    pub(crate) cells: Vec<Cell>,
}

impl Colored {
    /// The colour of a spectrum, at a place.
    pub(crate) fn seen(
        mut place: Vec<Cell>,
        illuminant: Illuminant,
        colorimeter: &Colorimeter,
        values: &[f64],
    ) -> Self {
        let xyz = colorimeter.xyz(values);
        let lab = Lab::from_xyz(xyz, colorimeter.white());
        let light = LinearRgb::from_xyz(xyz);
        place.push(Cell::Word(illuminant.name().to_owned()));
        place.extend([xyz.x, xyz.y, xyz.z, lab.l, lab.a, lab.b, light.r, light.g, light.b].map(Cell::from));
        Self { light, cells: place }
    }

    /// The false colour of values at three wavelengths, at a place.
    pub(crate) fn in_false_color(mut place: Vec<Cell>, [r, g, b]: [f64; 3]) -> Self {
        place.extend([r, g, b].map(Cell::from));
        Self { light: LinearRgb { r, g, b }, cells: place }
    }

    /// The whole row at an exposure, as a factor.
    pub(crate) fn row(mut self, factor: f64) -> Vec<Cell> {
        let hex = hex(self.light * factor);
        self.cells.push(Cell::Word(hex));
        self.cells
    }
}

/// A colour as screens show it.
pub(crate) fn hex(colour: LinearRgb) -> String {
    Srgb8::encode(colour.displayable()).to_string()
}
