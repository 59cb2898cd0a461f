//! Transmittance and reflectance against wavelength, a line for each thickness and angle.

use std::ops::Range;

use snowblue_transport::slab::{Estimate, Incidence, Radiometry};
use svg::Node;
use svg::node::element::{LinearGradient, Stop};

use super::axis::Axis;
use super::canvas::{Canvas, GREY, INK, LABEL, Lettering, PALE, Point, Stroke, TICK};
use super::colours::{ordered_colour, wavelength_colour};

const WIDTH: f64 = 900.0;
const HEIGHT: f64 = 680.0;
const LEFT: f64 = 92.0;
const RIGHT: f64 = 712.0;
/// Top and bottom of either panel.
const TRANSMITTANCE: (f64, f64) = (64.0, 384.0);
const REFLECTANCE: (f64, f64) = (414.0, 590.0);
/// Transmittances that span more than this are drawn on a logarithmic axis.
const LINEAR_SPAN: f64 = 25.0;
/// Least span of a linear axis; a smaller one would show noise as a trend.
const LEAST_SPAN: f64 = 0.02;
/// Smaller values count as 0.
const SMALLEST: f64 = 1e-250;
/// Least ratio of a logarithmic axis's lower end to its upper end.
const LEAST_RATIO: f64 = 1e-30;
/// Curves with more points than this are drawn without dots.
const MOST_DOTS: usize = 12;
const DASHES: [&str; 5] = ["", "8 4", "2 3", "10 3 2 3", "5 2"];
/// Longest legend, in entries.
const MOST_ENTRIES: usize = 26;

/// Draws a solved slab: rows ordered by thickness, then incidence, then wavelength. On a ground that reflects, the
/// transmittance is the downward flux there.
pub fn spectrum(rows: &[Radiometry], metadata: &[(&'static str, String)], is_on_ground: bool) -> String {
    let curves: Vec<&[Radiometry]> = rows.chunk_by(same_slab).collect();
    let styles = Styles::of(&curves);
    let mut canvas = Canvas::new(WIDTH, HEIGHT, "Transmittance and reflectance of snow");
    let wavelengths = wavelength_axis(rows);
    let noisy = rows.iter().any(|row| row.transmittance.standard_error > 0.002 * row.transmittance.value);
    let transmittance = if is_on_ground { "Downward flux at the ground" } else { "Transmittance" };
    let panels: [((f64, f64), &str, Quantity); 2] =
        [(TRANSMITTANCE, transmittance, |row| row.transmittance), (REFLECTANCE, "Reflectance", |row| row.reflectance)];
    for (range, name, quantity) in panels {
        let estimates: Vec<Estimate> = rows.iter().map(quantity).collect();
        let panel = Panel { wavelengths: &wavelengths, values: &value_axis(&estimates, range == TRANSMITTANCE), range };
        panel.frame(&mut canvas, name);
        for (number, curve) in curves.iter().enumerate() {
            let mut points: Vec<(f64, Estimate)> = curve.iter().map(|row| (row.wavelength_nm, quantity(row))).collect();
            points.sort_by(|a, b| a.0.total_cmp(&b.0));
            panel.curve(&mut canvas, &points, &styles.colour(number), styles.dashes(number));
        }
    }
    wavelength_marks(&mut canvas, &wavelengths);
    styles.legend(&mut canvas, noisy);
    canvas.finish(HEIGHT - 18.0, metadata)
}

type Quantity = fn(&Radiometry) -> Estimate;

fn same_slab(a: &Radiometry, b: &Radiometry) -> bool {
    a.thickness_cm.to_bits() == b.thickness_cm.to_bits() && a.incidence == b.incidence
}

fn wavelength_axis(rows: &[Radiometry]) -> Axis {
    let (low, high) = ends(rows.iter().map(|row| row.wavelength_nm));
    let margin = if high > low { 0.0 } else { 25.0 };
    Axis::linear(low - margin, high + margin, 8.0)
}

/// Logarithmic for transmittances over a wide range, else linear over all values, and over error bands within 0–1.
fn value_axis(estimates: &[Estimate], is_transmittance: bool) -> Axis {
    let (low, high) = ends(estimates.iter().map(|e| e.value).filter(|value| *value > SMALLEST));
    let low = low.max(high * LEAST_RATIO);
    if is_transmittance && high > LINEAR_SPAN * low {
        let decade = |value: f64| 10_f64.powf(value.log10().floor());
        let round = |value: f64| (value / decade(value) * 1.000_001).floor() * decade(value);
        return Axis::logarithmic(round(low), (round(high) + decade(high)).min(1.0).max(high));
    }
    let bands = estimates.iter().flat_map(|e| [e.value - e.standard_error, e.value + e.standard_error]);
    let most = high.max(1.0);
    let (low, high) = ends(bands.map(|value| value.clamp(0.0, most)));
    let low = if is_transmittance || low < 0.5 * high { 0.0 } else { low.min(high - LEAST_SPAN) };
    Axis::linear_to_marks(low, high, 4.0)
}

fn ends(values: impl Iterator<Item = f64>) -> (f64, f64) {
    values.fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), value| (low.min(value), high.max(value)))
}

/// One set of axes.
struct Panel<'a> {
    wavelengths: &'a Axis,
    values: &'a Axis,
    range: (f64, f64),
}

impl Panel<'_> {
    fn point(&self, wavelength_nm: f64, value: f64) -> Point {
        let (top, bottom) = self.range;
        (
            LEFT + (RIGHT - LEFT) * self.wavelengths.fraction(wavelength_nm),
            bottom - (bottom - top) * self.values.fraction(value),
        )
    }

    fn frame(&self, canvas: &mut Canvas, name: &str) {
        let (top, bottom) = self.range;
        for mark in &self.wavelengths.marks {
            let (x, _) = self.point(*mark, 0.0);
            canvas.line((x, top), (x, bottom), Stroke::solid(PALE, 1.0));
        }
        for mark in &self.values.marks {
            let (_, y) = self.point(0.0, *mark);
            canvas.line((LEFT, y), (RIGHT, y), Stroke::solid(PALE, 1.0));
            canvas.text((LEFT - 8.0, y + 4.0), &self.values.label(*mark), Lettering { anchor: "end", ..TICK });
        }
        canvas.line((LEFT, bottom), (RIGHT, bottom), Stroke::solid(GREY, 1.0));
        canvas.line((LEFT, top), (LEFT, bottom), Stroke::solid(GREY, 1.0));
        canvas.vertical_text((30.0, 0.5 * (top + bottom)), name, LABEL);
    }

    /// A line with a band of ± 1 standard error; few points have dots and error bars.
    fn curve(&self, canvas: &mut Canvas, points: &[(f64, Estimate)], colour: &str, dashes: &str) {
        let shifted = |sign: f64| -> Vec<Point> {
            points.iter().map(|(nm, e)| self.point(*nm, e.value + sign * e.standard_error)).collect()
        };
        let (lower, middle, upper) = (shifted(-1.0), shifted(0.0), shifted(1.0));
        for part in self.visible_parts(points) {
            canvas.band(&lower[part.clone()], &upper[part.clone()], colour, 0.22);
            canvas.curve(&middle[part], Stroke { colour, width: 1.8, dashes });
        }
        if points.len() <= MOST_DOTS {
            for ((low, high), point) in lower.iter().zip(&upper).zip(&middle) {
                canvas.line(*low, *high, Stroke::solid(colour, 1.2));
                canvas.dot(*point, 2.8, colour);
            }
        }
    }

    /// Runs of points above the lower end of the axis, each with one more point at either end.
    fn visible_parts(&self, points: &[(f64, Estimate)]) -> Vec<Range<usize>> {
        let above = |i: usize| !self.values.logarithmic || points[i].1.value > self.values.low;
        let last = points.len().saturating_sub(1);
        let visible = |i: usize| (i.saturating_sub(1)..=(i + 1).min(last)).any(above);
        let numbers: Vec<usize> = (0..points.len()).filter(|i| visible(*i)).collect();
        numbers.chunk_by(|a, b| a + 1 == *b).map(|part| part[0]..part[part.len() - 1] + 1).collect()
    }
}

/// Marks under the lower panel, with a strip of spectral colours.
fn wavelength_marks(canvas: &mut Canvas, axis: &Axis) {
    let x = |nm: f64| LEFT + (RIGHT - LEFT) * axis.fraction(nm);
    let bottom = REFLECTANCE.1;
    let (first, last) = (axis.low.max(390.0), axis.high.min(740.0));
    if first < last {
        let mut gradient = LinearGradient::new();
        for i in 0..=60 {
            let offset = f64::from(i) / 60.0;
            let wavelength_nm = first + offset * (last - first);
            // The sensitivity of the eye fades at both ends.
            let opacity = ((wavelength_nm - 385.0) / 40.0).min((745.0 - wavelength_nm) / 60.0).clamp(0.0, 1.0);
            let stop = Stop::new().set("offset", offset).set("stop-color", wavelength_colour(wavelength_nm));
            gradient.append(stop.set("stop-opacity", opacity));
        }
        canvas.gradient(gradient, "visible", (x(first), bottom + 1.0), (x(last) - x(first), 5.0));
    }
    for mark in &axis.marks {
        canvas.text((x(*mark), bottom + 24.0), &axis.label(*mark), TICK);
    }
    canvas.text((0.5 * (LEFT + RIGHT), bottom + 46.0), "Wavelength (nm)", Lettering { anchor: "middle", ..LABEL });
}

/// Line styles: colours for thicknesses and dashes for angles, or colours for whichever of the two varies.
struct Styles {
    slabs: Vec<(f64, Incidence)>,
    thicknesses_cm: Vec<f64>,
    incidences: Vec<Incidence>,
}

/// Indices of a thickness and an incidence.
struct Steps {
    thickness: usize,
    angle: usize,
}

impl Styles {
    fn of(curves: &[&[Radiometry]]) -> Self {
        let slabs: Vec<(f64, Incidence)> =
            curves.iter().map(|curve| (curve[0].thickness_cm, curve[0].incidence)).collect();
        let mut thicknesses_cm: Vec<f64> = Vec::new();
        let mut incidences: Vec<Incidence> = Vec::new();
        for (thickness_cm, incidence) in &slabs {
            if !thicknesses_cm.iter().any(|known| known.to_bits() == thickness_cm.to_bits()) {
                thicknesses_cm.push(*thickness_cm);
            }
            if !incidences.contains(incidence) {
                incidences.push(*incidence);
            }
        }
        Self { slabs, thicknesses_cm, incidences }
    }

    fn by_angle(&self) -> bool {
        self.thicknesses_cm.len() == 1
    }

    fn both(&self) -> bool {
        !self.by_angle() && self.incidences.len() > 1
    }

    /// Indices of a curve's thickness and incidence.
    fn steps(&self, curve: usize) -> Steps {
        let (thickness_cm, incidence) = self.slabs[curve];
        let thickness = self.thicknesses_cm.iter().position(|known| known.to_bits() == thickness_cm.to_bits());
        let angle = self.incidences.iter().position(|known| *known == incidence);
        Steps { thickness: thickness.unwrap_or(0), angle: angle.unwrap_or(0) }
    }

    fn colour(&self, curve: usize) -> String {
        let Steps { thickness, angle } = self.steps(curve);
        if self.by_angle() {
            ordered_colour(angle, self.incidences.len())
        } else {
            ordered_colour(thickness, self.thicknesses_cm.len())
        }
    }

    fn dashes(&self, curve: usize) -> &'static str {
        if self.both() { DASHES[self.steps(curve).angle % DASHES.len()] } else { "" }
    }

    fn legend(&self, canvas: &mut Canvas, noisy: bool) {
        let thickness = |thickness_cm: &f64| format!("{thickness_cm} cm");
        let angle = |incidence: &Incidence| match incidence {
            Incidence::Beam { .. } => format!("{incidence}°"),
            Incidence::Diffuse => incidence.to_string(),
        };
        let coloured = |names: Vec<String>| -> Vec<(String, String, &'static str)> {
            let count = names.len();
            names.into_iter().enumerate().map(|(i, name)| (name, ordered_colour(i, count), "")).collect()
        };
        let (thicknesses, angles) =
            (self.thicknesses_cm.iter().map(thickness).collect::<Vec<_>>(), self.incidences.iter().map(angle));
        let mut groups = Vec::new();
        if self.by_angle() {
            groups.push(("Incidence", format!("on {}", thicknesses[0]), coloured(angles.collect())));
        } else if self.both() {
            groups.push(("Thickness", String::new(), coloured(thicknesses)));
            let dashed = |(i, name)| (name, INK.to_owned(), DASHES[i % DASHES.len()]);
            groups.push(("Incidence", String::new(), angles.enumerate().map(dashed).collect()));
        } else {
            groups.push(("Thickness", format!("incidence {}", angles.collect::<String>()), coloured(thicknesses)));
        }
        let most = MOST_ENTRIES / groups.len();
        let (x, mut y) = (RIGHT + 28.0, TRANSMITTANCE.0 + 10.0);
        let grey = Lettering { size: 12.0, fill: GREY, ..LABEL };
        for (title, remark, mut entries) in groups {
            canvas.text((x, y), title, Lettering { bold: true, ..LABEL });
            if !remark.is_empty() {
                y += 17.0;
                canvas.text((x, y), &remark, grey);
            }
            let left_out = entries.len().saturating_sub(most);
            entries.truncate(most);
            for (name, colour, dashes) in entries {
                y += 19.0;
                canvas.line((x, y - 4.0), (x + 30.0, y - 4.0), Stroke { colour: &colour, width: 2.2, dashes });
                canvas.text((x + 40.0, y), &name, LABEL);
            }
            if left_out > 0 {
                y += 19.0;
                canvas.text((x + 40.0, y), &format!("and {left_out} more"), grey);
            }
            y += 32.0;
        }
        if noisy {
            canvas.text((x, REFLECTANCE.1), "bands: ± 1 standard error", Lettering { size: 11.0, ..grey });
        }
    }
}
