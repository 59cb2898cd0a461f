//! Polar plot of the light that leaves a slab in the plane of incidence: BRDF above, BTDF below, each on its own scale.

use snowblue_transport::monte_carlo::{Distribution, PlanePoint};
use snowblue_transport::slab::{Estimate, Incidence};

use super::axis::{Axis, power_of_ten};
use super::chart::{Chart, GREY, HEADING, LABEL, Lettering, PALE, Point, REMARK, Stroke, TICK, ordered_colours};

const CENTRE_X: f64 = 366.0;
const RADIUS: f64 = 258.0;
/// Heights of the faces of the slab, in pixels.
const TOP: f64 = 366.0;
const BOTTOM: f64 = 414.0;
const LIGHT: &str = "#d9730d";
const SNOW: &str = "#e8f1f8";

/// One hemisphere of the plot.
struct Half {
    scale: Axis,
    /// Height of the centre, in pixels.
    face: f64,
    /// 1 for the upper half, −1 for the lower.
    up: f64,
}

/// Draws the distributions of one slab at one angle of incidence, a curve for each wavelength.
pub fn bsdf(distributions: &[Distribution], metadata: &[(&'static str, String)]) -> String {
    let mut chart = Chart::new(900.0, 750.0, "Light scattered by snow, in the plane of incidence");
    let snow = [(CENTRE_X - RADIUS, TOP), (CENTRE_X + RADIUS, TOP)];
    chart.band(&snow, &snow.map(|(x, _)| (x, BOTTOM)), SNOW, 1.0);
    if let Some(first) = distributions.first() {
        let thickness = first.thickness_cm;
        let words = if thickness.is_finite() { format!("{thickness} cm of snow") } else { "deep snow".to_owned() };
        chart.text((CENTRE_X - RADIUS + 10.0, 0.5 * (TOP + BOTTOM) + 4.0), &words, LABEL);
    }
    let colours = ordered_colours(distributions.len());
    let above: Vec<_> = distributions.iter().map(|one| one.in_plane(&one.reflection)).collect();
    let below: Vec<_> = distributions.iter().map(|one| one.in_plane(&one.transmission)).collect();
    for (name, face, up, curves) in [("BRDF (1/sr)", TOP, 1.0, above), ("BTDF (1/sr)", BOTTOM, -1.0, below)] {
        let half = Half::new(curves.iter().flatten(), face, up);
        half.grid(&mut chart, name);
        if let Some(Incidence::Beam { angle_deg }) = distributions.first().map(|first| first.incidence) {
            half.beam(&mut chart, angle_deg);
        }
        for (points, colour) in curves.iter().zip(&colours) {
            half.curve(&mut chart, points, colour);
        }
    }
    legend(&mut chart, distributions, &colours);
    chart.finish(metadata)
}

impl Half {
    /// A half whose scale holds all points and their errors.
    fn new<'p>(points: impl Iterator<Item = &'p PlanePoint>, face: f64, up: f64) -> Self {
        let most = points.map(|point| point.bsdf_per_sr.value + error(point.bsdf_per_sr)).fold(0.0, f64::max);
        Self { scale: Axis::linear_to_marks(0.0, if most > 0.0 { most } else { 1.0 }, 4.0), face, up }
    }

    /// The point at an angle from the normal and a distance from the centre, in pixels. The forward direction is to
    /// the right.
    fn at(&self, theta_deg: f64, radius: f64) -> Point {
        let (sine, cosine) = theta_deg.to_radians().sin_cos();
        (CENTRE_X + radius * sine, self.face - self.up * radius * cosine)
    }

    /// Circles and spokes with their values.
    fn grid(&self, chart: &mut Chart, name: &str) {
        for theta_deg in [-60.0, -30.0, 0.0, 30.0, 60.0_f64] {
            chart.curve(&[self.at(0.0, 0.0), self.at(theta_deg, RADIUS)], Stroke::solid(PALE, 1.0));
            let (x, y) = self.at(theta_deg, RADIUS + 16.0);
            chart.text((x, y + 4.0), &format!("{}°", theta_deg.abs()), TICK);
        }
        for mark in self.scale.marks.iter().filter(|mark| **mark > 0.0) {
            let radius = RADIUS * self.scale.fraction(*mark);
            let arc: Vec<Point> = (-45..=45).map(|i| self.at(f64::from(2 * i), radius)).collect();
            chart.curve(&arc, Stroke::solid(PALE, 1.0));
            chart.text(self.beside(radius), &self.scale.label(*mark), TICK);
        }
        chart.curve(&[self.at(-90.0, RADIUS), self.at(90.0, RADIUS)], Stroke::solid(GREY, 1.0));
        chart.text(self.beside(24.0), name, Lettering { size: 12.0, anchor: "end", ..HEADING });
    }

    /// The place of a label within the slab, at a distance from the centre.
    fn beside(&self, radius: f64) -> Point {
        let (x, y) = self.at(90.0, radius);
        (x, y + 4.0 + self.up * 11.0)
    }

    /// The incident beam from the left, or its continuation below.
    fn beam(&self, chart: &mut Chart, angle_deg: f64) {
        let stroke = Stroke { colour: LIGHT, width: 1.2, dashes: if self.up > 0.0 { "6 4" } else { "2 4" } };
        chart.curve(&[self.at(0.0, 0.0), self.at(-self.up * angle_deg, RADIUS)], stroke);
    }

    /// A line with a band of ± 1 standard error.
    fn curve(&self, chart: &mut Chart, points: &[PlanePoint], colour: &str) {
        let [lower, middle, upper] = [-1.0, 0.0, 1.0].map(|sign| {
            let point = |point: &PlanePoint| {
                let end = point.bsdf_per_sr.value + sign * error(point.bsdf_per_sr);
                self.at(point.theta_deg, RADIUS * self.scale.fraction(end))
            };
            points.iter().map(point).collect::<Vec<_>>()
        });
        chart.band(&lower, &upper, colour, 0.2);
        chart.curve(&middle, Stroke::solid(colour, 2.0));
        chart.dots(&middle, 2.6, colour);
    }
}

/// A line for each wavelength with its reflectance, transmittance and direct transmittance.
fn legend(chart: &mut Chart, distributions: &[Distribution], colours: &[String]) {
    let (x, mut y) = (CENTRE_X + RADIUS + 66.0, 96.0);
    for (distribution, colour) in distributions.iter().zip(colours) {
        let name = format!("{} nm", distribution.wavelength_nm);
        chart.legend((x, y), "", &[(name, Stroke::solid(colour, 2.4))]);
        let Distribution { reflectance, transmittance, direct, .. } = distribution;
        for (name, flux) in [("R", reflectance), ("T", transmittance), ("direct", direct)] {
            y += 16.0;
            chart.text((x + 36.0, y), &format!("{name} = {}", with_error(*flux)), REMARK);
        }
        y += 24.0;
    }
    if distributions.iter().any(|distribution| distribution.incidence != Incidence::Diffuse) {
        let line = |dashes| Stroke { colour: LIGHT, width: 1.2, dashes };
        let entries = [("incident beam".to_owned(), line("6 4")), ("direct light".to_owned(), line("2 4"))];
        y = chart.legend((x, y), "", &entries);
    }
    let mut patches = distributions.iter().flat_map(|distribution| &distribution.reflection);
    if patches.any(|patch| !patch.bsdf_per_sr.standard_error.is_nan()) {
        chart.text((x, y), "bands: ± 1 standard error", Lettering { size: 11.0, ..REMARK });
    }
}

/// The standard error; none of discrete ordinates.
fn error(estimate: Estimate) -> f64 {
    estimate.standard_error.max(0.0)
}

/// A flux and its standard error.
fn with_error(flux: Estimate) -> String {
    match flux.value {
        value if value <= 0.0 => "0".to_owned(),
        value if value < 1e-3 => format!("{} ± {}", power_of_ten(value), power_of_ten(flux.standard_error)),
        value => format!("{value:.4} ± {:.4}", flux.standard_error),
    }
}
