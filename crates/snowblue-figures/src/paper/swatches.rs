//! Sheets of colours in rows and columns.

use snowblue_color::Xyz;
use snowblue_color::exposure::AutoExposure;
use snowblue_color::{LinearRgb, Srgb8};

use crate::plot::{Chart, LABEL, Lettering};

/// The colours of lights as shown, all at one exposure, which brings the brightest light near white.
pub(super) struct Exposed {
    factor: f64,
}

impl Exposed {
    pub(super) fn together(lights: impl Iterator<Item = Xyz>) -> Self {
        Self { factor: AutoExposure::OF_COLORS.factor(lights.map(LinearRgb::from_xyz)) }
    }

    pub(super) fn colour(&self, light: Xyz) -> Srgb8 {
        Srgb8::encode(LinearRgb::from_xyz(light * self.factor).displayable())
    }

    pub(super) fn words(&self) -> String {
        format!("exposure +{:.2} stops for all", self.factor.log2())
    }
}

/// Draws a sheet from the upper left corner of its first colour, with labels to the left of rows and above columns.
pub(super) fn draw(
    chart: &mut Chart,
    (left, top): (f64, f64),
    size: (f64, f64),
    columns: &[String],
    rows: &[(String, Vec<Srgb8>)],
) {
    for (number, label) in columns.iter().enumerate() {
        let middle = left + size.0 * (number as f64 + 0.5);
        chart.text((middle, top - 8.0), label, Lettering { anchor: "middle", ..LABEL });
    }
    for (row, (label, colours)) in rows.iter().enumerate() {
        let y = top + size.1 * row as f64;
        chart.text((left - 12.0, y + 0.5 * size.1 + 4.0), label, Lettering { anchor: "end", ..LABEL });
        for (column, colour) in colours.iter().enumerate() {
            chart.rectangle((left + size.0 * column as f64, y), size, *colour);
        }
    }
}
