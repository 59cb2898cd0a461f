//! Transmittance and reflectance against wavelength, a line for each thickness and angle.

use snowblue_transport::slab::{Estimate, Incidence, Radiometry};

use super::axis::Axis;
use super::chart::{Area, Chart, INK, Lettering, REMARK, Stroke, ordered_colours};
const LEFT: f64 = 92.0;
const RIGHT: f64 = 712.0;
/// Transmittances that span more than this are drawn on a logarithmic axis.
const LINEAR_SPAN: f64 = 25.0;
/// Least ratio of a logarithmic axis's lower end to its upper end.
const MIN_RATIO: f64 = 1e-30;
/// Least span of a linear axis. A smaller span would show noise as a trend.
const MIN_SPAN: f64 = 0.02;
/// Curves with more points than this are drawn without dots.
const MAX_DOTS: usize = 12;
/// Longest legend, in entries.
const MAX_ENTRIES: usize = 26;
const DASHES: [&str; 5] = ["", "8 4", "2 3", "10 3 2 3", "5 2"];

type Quantity = fn(&Radiometry) -> Estimate;

/// Draws a solved slab: rows ordered by thickness, then incidence, then wavelength. On a ground that reflects, the
/// transmittance is the downward flux there.
pub fn spectrum(rows: &[Radiometry], metadata: &[(&'static str, String)], is_on_ground: bool) -> String {
    let transmittance = if is_on_ground { "Downward flux at the ground" } else { "Transmittance" };
    let panels: [(f64, f64, &str, Quantity); 2] = [
        (64.0, 364.0, transmittance, |row| row.fluxes.transmittance),
        (424.0, 600.0, "Reflectance", |row| row.fluxes.reflectance),
    ];
    let mut chart = Chart::new(900.0, 690.0, "Transmittance and reflectance of snow");
    let (thicknesses, angles) = (Styles::of(rows, "Thickness", thickness), Styles::of(rows, "Incidence", angle));
    let by_angle = thicknesses.names.len() == 1;
    let (coloured, dashed) = if by_angle { (&angles, &thicknesses) } else { (&thicknesses, &angles) };
    let colours = ordered_colours(coloured.names.len());
    let (first_nm, last_nm) = ends(rows.iter().map(|row| row.wavelength_nm));
    let margin_nm = if last_nm > first_nm { 0.0 } else { 25.0 };
    for (top, bottom, name, quantity) in panels {
        let estimates: Vec<Estimate> = rows.iter().map(quantity).collect();
        let nm = Axis::linear(first_nm - margin_nm, last_nm + margin_nm, 8.0);
        let values = value_axis(&estimates, name != "Reflectance");
        let area = Area { left: LEFT, right: RIGHT, top, bottom };
        let panel = chart.panel(area, [nm, values], ["Wavelength (nm)", name]);
        for curve in rows.chunk_by(|a, b| thickness(a) == thickness(b) && angle(a) == angle(b)) {
            let mut curve = curve.to_vec();
            curve.sort_by(|a, b| a.wavelength_nm.total_cmp(&b.wavelength_nm));
            let [lower, middle, upper] = [-1.0, 0.0, 1.0].map(|sign| {
                let value = |row: &Radiometry| quantity(row).value + sign * quantity(row).standard_error;
                curve.iter().map(|row| panel.point((row.wavelength_nm, value(row)))).collect::<Vec<_>>()
            });
            let colour = &colours[coloured.number(&curve[0])];
            let dashes = DASHES[dashed.number(&curve[0]) % DASHES.len()];
            chart.band(&lower, &upper, colour, 0.22);
            chart.curve(&middle, Stroke { colour, width: 1.8, dashes });
            if curve.len() <= MAX_DOTS {
                chart.dots(&middle, 2.8, colour);
            }
        }
    }
    let strokes = colours.iter().map(|colour| Stroke::solid(colour, 2.2));
    let y = coloured.legend(&mut chart, 74.0, strokes);
    dashed.legend(&mut chart, y, DASHES.into_iter().cycle().map(|dashes| Stroke { colour: INK, width: 1.8, dashes }));
    if rows.iter().any(|row| row.fluxes.transmittance.standard_error > 0.002 * row.fluxes.transmittance.value) {
        chart.text((RIGHT + 28.0, 600.0), "bands: ± 1 standard error", Lettering { size: 11.0, ..REMARK });
    }
    chart.finish(metadata)
}

fn thickness(row: &Radiometry) -> String {
    format!("{} cm", row.thickness_cm)
}

fn angle(row: &Radiometry) -> String {
    match row.incidence {
        Incidence::Beam { .. } => format!("{}°", row.incidence),
        Incidence::Diffuse => row.incidence.to_string(),
    }
}

/// Logarithmic for transmittances over a wide range, else linear over all values, and over error bands within 0–1.
fn value_axis(estimates: &[Estimate], is_transmittance: bool) -> Axis {
    let (low, high) = ends(estimates.iter().map(|estimate| estimate.value).filter(|value| *value > 0.0));
    let low = low.max(high * MIN_RATIO);
    if is_transmittance && high > LINEAR_SPAN * low {
        let decade = |value: f64| 10_f64.powf(value.log10().floor());
        let round = |value: f64| (value / decade(value) * 1.000_001).floor() * decade(value);
        return Axis::logarithmic(round(low), (round(high) + decade(high)).min(1.0).max(high));
    }
    let bands = estimates.iter().flat_map(|e| [e.value - e.standard_error, e.value + e.standard_error]);
    let most = high.max(1.0);
    let (low, high) = ends(bands.map(|value| value.clamp(0.0, most)));
    let low = if is_transmittance || low < 0.5 * high { 0.0 } else { low.min(high - MIN_SPAN) };
    Axis::linear_to_marks(low, high, 4.0)
}

fn ends(values: impl Iterator<Item = f64>) -> (f64, f64) {
    values.fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), value| (low.min(value), high.max(value)))
}

/// A property of the slabs that colours or dashes distinguish: its distinct values, in words.
struct Styles {
    title: &'static str,
    name: fn(&Radiometry) -> String,
    names: Vec<String>,
}

impl Styles {
    fn of(rows: &[Radiometry], title: &'static str, name: fn(&Radiometry) -> String) -> Self {
        let mut names = Vec::new();
        for row in rows.iter().map(name) {
            if !names.contains(&row) {
                names.push(row);
            }
        }
        Self { title, name, names }
    }

    fn number(&self, row: &Radiometry) -> usize {
        let own = (self.name)(row);
        self.names.iter().position(|name| *name == own).unwrap_or_default()
    }

    /// Entries beside the upper panel, below `y`; returns where another legend can follow.
    fn legend<'s>(&self, chart: &mut Chart, y: f64, strokes: impl Iterator<Item = Stroke<'s>>) -> f64 {
        let x = RIGHT + 28.0;
        let most = MAX_ENTRIES / 2;
        let entries: Vec<_> = self.names.iter().cloned().zip(strokes).take(most).collect();
        let y = chart.legend((x, y), self.title, &entries);
        if self.names.len() <= most {
            return y;
        }
        chart.text((x + 36.0, y - 14.0), &format!("and {} more", self.names.len() - most), REMARK);
        y + 18.0
    }
}
