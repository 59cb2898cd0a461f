//! Polar plot of the light that leaves a slab in the plane of incidence: BRDF above, BTDF below, each on its own scale.

use snowblue_transport::monte_carlo::{Distribution, Patch, PlanePoint};
use snowblue_transport::slab::{Estimate, Incidence};

use super::axis::{Axis, power_of_ten};
use super::canvas::{Canvas, GREY, LABEL, Lettering, PALE, Point, Stroke, TICK};
use super::colours::wavelength_colour;

const WIDTH: f64 = 900.0;
const HEIGHT: f64 = 790.0;
const CENTRE_X: f64 = 366.0;
const RADIUS: f64 = 258.0;
/// Heights of the faces of the slab, in pixels.
const TOP: f64 = 396.0;
const BOTTOM: f64 = 444.0;
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
    let mut canvas = Canvas::new(WIDTH, HEIGHT, "Light scattered by snow, in the plane of incidence");
    let snow = [(CENTRE_X - RADIUS, TOP), (CENTRE_X + RADIUS, TOP)];
    canvas.band(&snow, &snow.map(|(x, _)| (x, BOTTOM)), SNOW, 1.0);
    let reflected = |distribution: &Distribution| distribution.in_plane(&distribution.reflection);
    let transmitted = |distribution: &Distribution| distribution.in_plane(&distribution.transmission);
    let above = Half::new(distributions.iter().flat_map(reflected), TOP, 1.0);
    let below = Half::new(distributions.iter().flat_map(transmitted), BOTTOM, -1.0);
    let incidence = distributions.first().map_or(Incidence::Diffuse, |first| first.incidence);
    above.grid(&mut canvas, "BRDF (1/sr)", incidence);
    below.grid(&mut canvas, "BTDF (1/sr)", Incidence::Diffuse);
    if let Some(first) = distributions.first() {
        let words = format!("{} cm of snow", first.thickness_cm);
        canvas.text((CENTRE_X - RADIUS + 10.0, 0.5 * (TOP + BOTTOM) + 4.0), &words, LABEL);
        above.lambertian(&mut canvas, &first.reflection);
        below.lambertian(&mut canvas, &first.transmission);
        incident(&mut canvas, &above, &below, incidence);
    }
    for distribution in distributions {
        let colour = wavelength_colour(distribution.wavelength_nm);
        above.curve(&mut canvas, &reflected(distribution), &colour);
        below.curve(&mut canvas, &transmitted(distribution), &colour);
    }
    legend(&mut canvas, distributions);
    canvas.finish(HEIGHT - 18.0, metadata)
}

impl Half {
    /// A half whose scale holds all points and their errors.
    fn new(points: impl Iterator<Item = PlanePoint>, face: f64, up: f64) -> Self {
        let most = points.map(|point| point.bsdf_per_sr.value + point.bsdf_per_sr.standard_error).fold(0.0, f64::max);
        let most = if most > 0.0 { most } else { 1.0 };
        Self { scale: Axis::linear_to_marks(0.0, most, 4.0), face, up }
    }

    /// The point of a value at an angle from the normal; forward is to the right.
    fn point(&self, theta_deg: f64, value: f64) -> Point {
        self.at(theta_deg, RADIUS * self.scale.fraction(value))
    }

    fn at(&self, theta_deg: f64, radius: f64) -> Point {
        let (sine, cosine) = theta_deg.to_radians().sin_cos();
        (CENTRE_X + radius * sine, self.face - self.up * radius * cosine)
    }

    /// Circles and spokes with their values, without the label that the incident beam covers.
    fn grid(&self, canvas: &mut Canvas, name: &str, incidence: Incidence) {
        for theta_deg in [-60.0, -30.0, 0.0, 30.0, 60.0_f64] {
            canvas.line(self.at(0.0, 0.0), self.at(theta_deg, RADIUS), Stroke::solid(PALE, 1.0));
            let (x, y) = self.at(theta_deg, RADIUS + 16.0);
            if !matches!(incidence, Incidence::Beam { angle_deg } if (angle_deg + theta_deg).abs() < 6.0) {
                canvas.text((x, y + 4.0), &format!("{}°", theta_deg.abs()), TICK);
            }
        }
        let mut marks = self.scale.marks.iter().filter(|mark| **mark > 0.0).peekable();
        while let Some(mark) = marks.next() {
            let outermost = marks.peek().is_none();
            self.arc(canvas, *mark, Stroke::solid(if outermost { GREY } else { PALE }, 1.0));
            let (x, y) = self.point(90.0, *mark);
            canvas.text(
                (x, y + self.up * 13.0 + if self.up > 0.0 { 2.0 } else { 6.0 }),
                &self.scale.label(*mark),
                TICK,
            );
        }
        canvas.line(self.at(-90.0, RADIUS), self.at(90.0, RADIUS), Stroke::solid(GREY, 1.0));
        let (x, y) = self.at(90.0, 24.0);
        let style = Lettering { size: 12.0, anchor: "end", bold: true, ..LABEL };
        canvas.text((x, y + self.up * 13.0 + if self.up > 0.0 { 2.0 } else { 6.0 }), name, style);
    }

    fn arc(&self, canvas: &mut Canvas, value: f64, stroke: Stroke) {
        let points: Vec<Point> = (-45..=45).map(|i| self.point(f64::from(2 * i), value)).collect();
        canvas.curve(&points, stroke);
    }

    /// A Lambertian surface of the same diffuse flux: flux / π.
    fn lambertian(&self, canvas: &mut Canvas, patches: &[Patch]) {
        let mean = patches.iter().map(|patch| patch.bsdf_per_sr.value).sum::<f64>() / patches.len() as f64;
        self.arc(canvas, mean, Stroke { colour: GREY, width: 1.2, dashes: "2 4" });
    }

    /// A line with a band of ± 1 standard error.
    fn curve(&self, canvas: &mut Canvas, points: &[PlanePoint], colour: &str) {
        let shifted = |sign: f64| -> Vec<Point> {
            let point = |plane_point: &PlanePoint| {
                let Estimate { value, standard_error } = plane_point.bsdf_per_sr;
                self.point(plane_point.theta_deg, (value + sign * standard_error).max(0.0))
            };
            points.iter().map(point).collect()
        };
        canvas.band(&shifted(-1.0), &shifted(1.0), colour, 0.2);
        let middle = shifted(0.0);
        canvas.curve(&middle, Stroke::solid(colour, 2.0));
        for point in middle {
            canvas.dot(point, 2.6, colour);
        }
    }
}

/// The incident beam from the left, and its continuation below.
fn incident(canvas: &mut Canvas, above: &Half, below: &Half, incidence: Incidence) {
    let Incidence::Beam { angle_deg } = incidence else {
        return;
    };
    let stroke = Stroke { colour: LIGHT, width: 1.2, dashes: "6 4" };
    canvas.line(above.at(-angle_deg, RADIUS + 30.0), above.at(0.0, 0.0), stroke);
    canvas.line(below.at(0.0, 0.0), below.at(angle_deg, RADIUS), Stroke { dashes: "2 4", ..stroke });
    let (tail, tip) = (above.at(-angle_deg, RADIUS + 64.0), above.at(-angle_deg, RADIUS + 30.0));
    canvas.line(tail, tip, Stroke::solid(LIGHT, 3.0));
    let along = ((tip.0 - tail.0) / 34.0, (tip.1 - tail.1) / 34.0);
    let barb = |side: f64| (tip.0 - 6.0 * along.0 - side * along.1, tip.1 - 6.0 * along.1 + side * along.0);
    let point = (tip.0 + 8.0 * along.0, tip.1 + 8.0 * along.1);
    canvas.band(&[barb(-7.0), point], &[barb(7.0)], LIGHT, 1.0);
    let (x, y) = above.at(-angle_deg, RADIUS + 80.0);
    canvas.text(
        (x, y + 5.0),
        &format!("{angle_deg}°"),
        Lettering { fill: LIGHT, bold: true, anchor: "middle", ..LABEL },
    );
}

/// A line for each wavelength with its reflectance, transmittance and direct transmittance.
fn legend(canvas: &mut Canvas, distributions: &[Distribution]) {
    let (x, mut y) = (CENTRE_X + RADIUS + 96.0, 96.0);
    let grey = Lettering { size: 12.0, fill: GREY, ..LABEL };
    for distribution in distributions {
        let colour = wavelength_colour(distribution.wavelength_nm);
        canvas.line((x, y - 4.0), (x + 26.0, y - 4.0), Stroke::solid(&colour, 2.4));
        canvas.dot((x + 13.0, y - 4.0), 3.0, &colour);
        canvas.text((x + 36.0, y), &format!("{} nm", distribution.wavelength_nm), Lettering { bold: true, ..LABEL });
        for (name, flux) in
            [("R", distribution.reflectance), ("T", distribution.transmittance), ("direct", distribution.direct)]
        {
            y += 16.0;
            canvas.text((x + 36.0, y), &format!("{name} = {}", with_error(flux)), grey);
        }
        y += 28.0;
    }
    let lambertian = distributions
        .first()
        .map_or_else(String::new, |distribution| format!("Lambertian at {} nm", distribution.wavelength_nm));
    let beam = distributions.iter().any(|distribution| distribution.incidence != Incidence::Diffuse);
    let lines = [("2 4", GREY, lambertian.as_str()), ("6 4", LIGHT, "incident beam"), ("2 4", LIGHT, "direct light")];
    for (dashes, colour, words) in lines.into_iter().take(if beam { 3 } else { 1 }) {
        canvas.line((x, y - 4.0), (x + 26.0, y - 4.0), Stroke { colour, width: 1.2, dashes });
        canvas.text((x + 36.0, y), words, grey);
        y += 19.0;
    }
    canvas.text((x, y + 8.0), "bands: ± 1 standard error", Lettering { size: 11.0, ..grey });
}

/// A flux and its standard error.
fn with_error(flux: Estimate) -> String {
    match flux.value {
        value if value <= 0.0 => "0".to_owned(),
        value if value < 1e-3 => format!("{} ± {}", power_of_ten(value), power_of_ten(flux.standard_error)),
        value => format!("{value:.4} ± {:.4}", flux.standard_error),
    }
}
