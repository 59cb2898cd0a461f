//! What diagrams need beyond lines and words: outlines, arrows, and the end of a drawing that has no chart.

use svg::Node;
use svg::node::element::Path as Shape;

use super::{Canvas, Metadata, Place, Stroke, stroked, through};

/// Length and half the width of an arrow's head, in pixels.
const HEAD: (f64, f64) = (9.0, 3.4);

impl Canvas {
    /// A closed outline with its filling.
    pub(crate) fn outline(&mut self, corners: &[Place], fill: &str, stroke: Stroke) {
        let mut shape = stroked(Shape::new().set("d", through(corners).close()), stroke);
        shape.assign("fill", fill);
        shape.assign("stroke-linejoin", "round");
        self.0.append(shape);
    }

    /// A line that ends in a full head.
    pub(crate) fn arrow(&mut self, from: Place, to: Place, stroke: Stroke) {
        let (along, across) = (to.0 - from.0, to.1 - from.1);
        let length = along.hypot(across);
        if length < HEAD.0 {
            return self.line(from, to, stroke);
        }
        let (along, across) = (along / length, across / length);
        let foot = (to.0 - HEAD.0 * along, to.1 - HEAD.0 * across);
        let side = |sign: f64| (foot.0 - sign * HEAD.1 * across, foot.1 + sign * HEAD.1 * along);
        self.line(from, foot, stroke);
        self.outline(&[side(1.0), to, side(-1.0)], stroke.colour, Stroke::full(stroke.colour, 0.5));
    }

    /// An arc about a centre from one direction to another, both in radians from the right and downwards.
    pub(crate) fn arc(&mut self, centre: Place, radius: f64, (from, to): (f64, f64), stroke: Stroke) {
        const STEPS: u32 = 32;
        let place = |step: u32| {
            let angle = from + (to - from) * f64::from(step) / f64::from(STEPS);
            (centre.0 + radius * angle.cos(), centre.1 + radius * angle.sin())
        };
        self.curve(&(0..=STEPS).map(place).collect::<Vec<_>>(), stroke);
    }

    /// The figure, with a closing line that says what made it.
    pub(crate) fn finish(mut self, baseline: f64, metadata: &Metadata) -> String {
        self.provenance(baseline, metadata);
        format!("{}\n", self.0)
    }
}
