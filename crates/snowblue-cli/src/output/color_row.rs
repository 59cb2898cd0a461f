//! Rows of colours: XYZ, CIELAB, linear sRGB and hex.

use snowblue_color::{Colorimeter, Illuminant, Lab, LinearRgb};
use snowblue_figures::Cell;

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

/// A colour and its row without the last cell: hex depends on an exposure that all rows share.
pub(crate) struct ColorRow {
    pub(crate) colour: LinearRgb,
    cells: Vec<Cell>,
}

impl ColorRow {
    /// The colour of a spectrum under an illuminant, after the leading cells.
    pub(crate) fn of_spectrum(
        mut leading: Vec<Cell>,
        illuminant: Illuminant,
        colorimeter: &Colorimeter,
        values: &[f64],
    ) -> Self {
        let xyz = colorimeter.xyz(values);
        let lab = Lab::from_xyz(xyz, colorimeter.white());
        let colour = LinearRgb::from_xyz(xyz);
        leading.push(Cell::word(illuminant.name()));
        leading.extend([xyz.x, xyz.y, xyz.z, lab.l, lab.a, lab.b, colour.r, colour.g, colour.b].map(Cell::from));
        Self { colour, cells: leading }
    }

    /// The complete row, with hex at an exposure factor.
    pub(crate) fn exposed(mut self, factor: f64) -> Vec<Cell> {
        self.cells.push(Cell::Word((self.colour * factor).display_hex()));
        self.cells
    }
}
