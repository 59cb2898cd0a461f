//! An SVG drawing surface: text, lines, curves, bands, outlines, arrows and images, in pixels.

use base64::Engine as _;
use base64::engine::general_purpose::STANDARD;
use svg::node::element::path::Data;
use svg::node::element::{Circle, Definitions, Image, Line, LinearGradient, Path, Rectangle, Text, Title};
use svg::{Document, Node};

pub(crate) const INK: &str = "#1f2933";
pub(crate) const GREY: &str = "#6b7785";
pub(crate) const PALE: &str = "#e1e6eb";

/// A point of the canvas, or a size: pixels to the right and down.
pub(crate) type Point = (f64, f64);

/// Style of a text.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Lettering {
    pub(crate) size: f64,
    pub(crate) fill: &'static str,
    /// `start`, `middle` or `end`.
    pub(crate) anchor: &'static str,
    pub(crate) bold: bool,
}

pub(crate) const LABEL: Lettering = Lettering { size: 13.0, fill: INK, anchor: "start", bold: false };
pub(crate) const TICK: Lettering = Lettering { size: 12.0, fill: GREY, anchor: "middle", bold: false };

/// Style of a line.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Stroke<'a> {
    pub(crate) colour: &'a str,
    pub(crate) width: f64,
    /// Lengths of dashes and gaps; empty for a solid line.
    pub(crate) dashes: &'a str,
}

impl<'a> Stroke<'a> {
    pub(crate) fn solid(colour: &'a str, width: f64) -> Self {
        Self { colour, width, dashes: "" }
    }
}

/// A drawing with its size.
pub(crate) struct Canvas {
    document: Document,
    width: f64,
    height: f64,
}

/// Longest line of metadata, in characters.
const METADATA_LINE: usize = 150;
/// Distance between baselines of metadata, in pixels.
const LINE_HEIGHT: f64 = 14.0;
/// Length and half the width of an arrow's head, in pixels.
const ARROW_LENGTH: f64 = 9.0;
const ARROW_HALF_WIDTH: f64 = 3.4;

impl Canvas {
    pub(crate) fn new(width: f64, height: f64, title: &str) -> Self {
        let document = Document::new()
            .set("viewBox", (0.0, 0.0, width, height))
            .set("width", width)
            .set("height", height)
            .set("font-family", "Inter, 'Helvetica Neue', Helvetica, Arial, 'DejaVu Sans', sans-serif")
            .add(Title::new(title))
            .add(Rectangle::new().set("width", "100%").set("height", "100%").set("fill", "white"));
        let mut canvas = Self { document, width, height };
        canvas.text((24.0, 34.0), title, Lettering { size: 17.0, bold: true, ..LABEL });
        canvas
    }

    pub(crate) fn text(&mut self, (x, y): Point, words: &str, style: Lettering) {
        self.document.append(lettered(words, style).set("x", rounded(x)).set("y", rounded(y)));
    }

    /// Text that runs upwards, centred at a point.
    pub(crate) fn vertical_text(&mut self, (x, y): Point, words: &str, style: Lettering) {
        let turn = format!("translate({} {}) rotate(-90)", rounded(x), rounded(y));
        self.document.append(lettered(words, Lettering { anchor: "middle", ..style }).set("transform", turn));
    }

    pub(crate) fn line(&mut self, from: Point, to: Point, stroke: Stroke) {
        let line = Line::new()
            .set("x1", rounded(from.0))
            .set("y1", rounded(from.1))
            .set("x2", rounded(to.0))
            .set("y2", rounded(to.1));
        self.document.append(stroked(line, stroke));
    }

    pub(crate) fn curve(&mut self, points: &[Point], stroke: Stroke) {
        self.curves(&[points], stroke);
    }

    /// Curves of one style, as one shape.
    pub(crate) fn curves<C: AsRef<[Point]>>(&mut self, curves: &[C], stroke: Stroke) {
        let data = curves.iter().fold(Data::new(), |data, points| append_polyline(data, points.as_ref()));
        self.document.append(stroked(Path::new().set("d", data).set("stroke-linejoin", "round"), stroke));
    }

    /// A filled area between two curves.
    pub(crate) fn band(&mut self, lower: &[Point], upper: &[Point], fill: &str, opacity: f64) {
        let outline: Vec<Point> = lower.iter().chain(upper.iter().rev()).copied().collect();
        let shape = Path::new().set("d", polyline(&outline).close()).set("fill", fill).set("fill-opacity", opacity);
        self.document.append(shape);
    }

    pub(crate) fn dot(&mut self, (x, y): Point, radius: f64, fill: &str) {
        let circle = Circle::new().set("cx", rounded(x)).set("cy", rounded(y)).set("r", radius).set("fill", fill);
        self.document.append(circle);
    }

    /// A filled polygon with its outline.
    pub(crate) fn polygon(&mut self, corners: &[Point], fill: &str, stroke: Stroke) {
        let mut shape = stroked(Path::new().set("d", polyline(corners).close()), stroke);
        shape.assign("fill", fill);
        shape.assign("stroke-linejoin", "round");
        self.document.append(shape);
    }

    /// A line with a filled arrowhead at its end.
    pub(crate) fn arrow(&mut self, from: Point, to: Point, stroke: Stroke) {
        let (along, across) = (to.0 - from.0, to.1 - from.1);
        let length = along.hypot(across);
        if length < ARROW_LENGTH {
            return self.line(from, to, stroke);
        }
        let (along, across) = (along / length, across / length);
        let foot = (to.0 - ARROW_LENGTH * along, to.1 - ARROW_LENGTH * across);
        let side = |sign: f64| (foot.0 - sign * ARROW_HALF_WIDTH * across, foot.1 + sign * ARROW_HALF_WIDTH * along);
        self.line(from, foot, stroke);
        self.polygon(&[side(1.0), to, side(-1.0)], stroke.colour, Stroke::solid(stroke.colour, 0.5));
    }

    /// An arc about a centre, between two angles in radians, clockwise from the right.
    pub(crate) fn arc(&mut self, centre: Point, radius: f64, angles: std::ops::Range<f64>, stroke: Stroke) {
        const STEPS: u32 = 32;
        let point = |step: u32| {
            let angle = angles.start + (angles.end - angles.start) * f64::from(step) / f64::from(STEPS);
            (centre.0 + radius * angle.cos(), centre.1 + radius * angle.sin())
        };
        self.curve(&(0..=STEPS).map(point).collect::<Vec<_>>(), stroke);
    }

    /// A filled rectangle by its upper left corner and its size.
    pub(crate) fn rectangle(&mut self, (x, y): Point, (width, height): Point, fill: &str) {
        let shape = Rectangle::new().set("x", rounded(x)).set("y", rounded(y)).set("fill", fill);
        self.document.append(shape.set("width", rounded(width)).set("height", rounded(height)));
    }

    /// The bytes of a PNG file in a rectangle, by its upper left corner and its size.
    pub(crate) fn image(&mut self, (x, y): Point, (width, height): Point, png: &[u8]) {
        let shape = Image::new().set("x", rounded(x)).set("y", rounded(y)).set("preserveAspectRatio", "none");
        let source = format!("data:image/png;base64,{}", STANDARD.encode(png));
        self.document.append(shape.set("width", rounded(width)).set("height", rounded(height)).set("href", source));
    }

    /// A rectangle filled with a gradient of the given name.
    pub(crate) fn gradient(&mut self, gradient: LinearGradient, name: &str, (x, y): Point, (width, height): Point) {
        self.document.append(Definitions::new().add(gradient.set("id", name)));
        let strip = Rectangle::new().set("x", x).set("width", width);
        self.document.append(strip.set("y", y).set("height", height).set("fill", format!("url(#{name})")));
    }

    /// The SVG file, with metadata from `baseline` on. Long metadata takes several lines and makes the drawing higher.
    pub(crate) fn finish(mut self, baseline: f64, metadata: &[(&'static str, String)]) -> String {
        let (mut lines, mut line) = (Vec::new(), String::new());
        for word in metadata.iter().map(|(name, value)| format!("{name} {value}")) {
            if !line.is_empty() && line.chars().count() + word.chars().count() > METADATA_LINE {
                lines.push(std::mem::take(&mut line));
            }
            line.push_str(if line.is_empty() { "" } else { " · " });
            line.push_str(&word);
        }
        lines.push(line);
        let mut y = baseline;
        for line in &lines {
            self.text((24.0, y), line, Lettering { size: 10.5, fill: GREY, ..LABEL });
            y += LINE_HEIGHT;
        }
        let height = self.height + LINE_HEIGHT * (lines.len() - 1) as f64;
        self.document.assign("viewBox", (0.0, 0.0, self.width, height));
        self.document.assign("height", height);
        format!("{}\n", self.document)
    }
}

fn lettered(words: &str, style: Lettering) -> Text {
    Text::new(words)
        .set("font-size", style.size)
        .set("fill", style.fill)
        .set("text-anchor", style.anchor)
        .set("font-weight", if style.bold { 600 } else { 400 })
}

fn stroked<T: Node>(mut node: T, stroke: Stroke) -> T {
    node.assign("fill", "none");
    node.assign("stroke", stroke.colour);
    node.assign("stroke-width", stroke.width);
    if !stroke.dashes.is_empty() {
        node.assign("stroke-dasharray", stroke.dashes);
    }
    node
}

fn polyline(points: &[Point]) -> Data {
    append_polyline(Data::new(), points)
}

fn append_polyline(data: Data, points: &[Point]) -> Data {
    points.iter().enumerate().fold(data, |data, (i, (x, y))| {
        let point = (rounded(*x), rounded(*y));
        if i == 0 { data.move_to(point) } else { data.line_to(point) }
    })
}

/// Rounds to a hundredth of a pixel, to keep files small.
fn rounded(pixels: f64) -> f64 {
    (pixels * 100.0).round() / 100.0
}
