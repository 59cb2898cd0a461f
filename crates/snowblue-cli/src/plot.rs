//! Figures in SVG: the canvas, the axes and the colours that they share.
//!
//! Colours are told apart by people who see red and green alike: those of ordered things run along viridis (van der
//! Walt & Smith 2015), dark to light; a wavelength has its own, with its value written beside it. Figures are drawn here
//! with shapes of the `svg` crate: the plotting crates round places to whole pixels, or have no polar plot of two halves.

mod chart;
mod diagram;
mod fidelity;
mod polar;
mod spectra;

use std::path::Path;

use snowblue_color::{LinearRgb, Observer, Srgb8};
use svg::node::element::path::Data;
use svg::node::element::{Circle, Line, Path as Shape, Rectangle, Text, Title};
use svg::{Document, Node};

use crate::failure::{Failure, Outcome};
use crate::report::write_file;

pub(crate) use chart::{Area, Chart, Entry, Look, Panel};
pub(crate) use fidelity::{Cost, fidelity};
pub(crate) use polar::bsdf;
pub(crate) use spectra::spectrum;

/// What made a figure, name by name, as in a report.
pub(crate) type Metadata = [(&'static str, String)];

pub(crate) const INK: &str = "#1f2933";
pub(crate) const GREY: &str = "#6b7785";
pub(crate) const PALE: &str = "#e1e6eb";

/// A place on the canvas: pixels to the right and down.
pub(crate) type Place = (f64, f64);

/// How text stands at its place.
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

/// How a line looks.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Stroke<'a> {
    pub(crate) colour: &'a str,
    pub(crate) width: f64,
    /// Lengths of dashes and gaps; none for a full line.
    pub(crate) dashes: &'a str,
}

impl<'a> Stroke<'a> {
    pub(crate) fn full(colour: &'a str, width: f64) -> Self {
        Self { colour, width, dashes: "" }
    }
}

/// A figure under the pen, with its width and height.
pub(crate) struct Canvas(Document, Place);

/// Characters of a line of provenance.
const MOST_CHARACTERS: usize = 150;
/// From one of its lines to the next.
const LINE_HEIGHT: f64 = 14.0;

/// Checks before long work that an SVG file can stand at a place.
pub(crate) fn check_place(path: &Path) -> Outcome {
    if path.extension().is_none_or(|ending| !ending.eq_ignore_ascii_case("svg")) {
        return Err(Failure::Input(format!("{}: the drawing must end in .svg", path.display())));
    }
    crate::report::check_place(path)
}

impl Canvas {
    pub(crate) fn new(width: f64, height: f64, title: &str) -> Self {
        let document = Document::new()
            .set("viewBox", (0.0, 0.0, width, height))
            .set("width", width)
            .set("height", height)
            .set("font-family", "Inter, 'Helvetica Neue', Helvetica, Arial, 'DejaVu Sans', sans-serif")
            .add(Title::new(title))
            .add(Rectangle::new().set("width", "100%").set("height", "100%").set("fill", "white"));
        let mut canvas = Self(document, (width, height));
        canvas.text((24.0, 34.0), title, Lettering { size: 17.0, bold: true, ..LABEL });
        canvas
    }

    /// The closing line that says what made the figure.
    fn provenance(&mut self, baseline: f64, metadata: &Metadata) {
        let made: Vec<String> = metadata.iter().map(|(name, value)| format!("{name} {value}")).collect();
        // Where there is much to say the figure grows by more lines.
        let (mut lines, mut line) = (Vec::new(), String::new());
        for word in made {
            if !line.is_empty() && line.chars().count() + word.chars().count() > MOST_CHARACTERS {
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
        let (width, height) = self.1;
        let height = height + LINE_HEIGHT * (lines.len() - 1) as f64;
        self.0.assign("viewBox", (0.0, 0.0, width, height));
        self.0.assign("height", height);
    }

    pub(crate) fn text(&mut self, (x, y): Place, words: &str, style: Lettering) {
        self.0.append(lettered(words, style).set("x", rounded(x)).set("y", rounded(y)));
    }

    /// Text that runs upwards, centred at a place.
    fn text_upwards(&mut self, (x, y): Place, words: &str, style: Lettering) {
        let turn = format!("translate({} {}) rotate(-90)", rounded(x), rounded(y));
        self.0.append(lettered(words, Lettering { anchor: "middle", ..style }).set("transform", turn));
    }

    pub(crate) fn line(&mut self, from: Place, to: Place, stroke: Stroke) {
        let line = Line::new()
            .set("x1", rounded(from.0))
            .set("y1", rounded(from.1))
            .set("x2", rounded(to.0))
            .set("y2", rounded(to.1));
        self.0.append(stroked(line, stroke));
    }

    pub(crate) fn curve(&mut self, points: &[Place], stroke: Stroke) {
        self.curves(&[points], stroke);
    }

    /// Curves that look alike, as one shape.
    fn curves<C: AsRef<[Place]>>(&mut self, curves: &[C], stroke: Stroke) {
        let data = curves.iter().fold(Data::new(), |data, points| passing(data, points.as_ref()));
        self.0.append(stroked(Shape::new().set("d", data).set("stroke-linejoin", "round"), stroke));
    }

    /// A filled area between two curves.
    fn band(&mut self, lower: &[Place], upper: &[Place], fill: &str, opacity: f64) {
        let outline: Vec<Place> = lower.iter().chain(upper.iter().rev()).copied().collect();
        let shape = Shape::new().set("d", through(&outline).close()).set("fill", fill).set("fill-opacity", opacity);
        self.0.append(shape);
    }

    pub(crate) fn dot(&mut self, (x, y): Place, radius: f64, fill: &str) {
        let circle = Circle::new().set("cx", rounded(x)).set("cy", rounded(y)).set("r", radius).set("fill", fill);
        self.0.append(circle);
    }

    /// Writes the figure into a file, whole or not at all.
    fn save(&self, path: &Path) -> Outcome {
        write_file(path, format!("{}\n", self.0).as_bytes())
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

fn through(points: &[Place]) -> Data {
    passing(Data::new(), points)
}

fn passing(data: Data, points: &[Place]) -> Data {
    points.iter().enumerate().fold(data, |data, (i, (x, y))| {
        let place = (rounded(*x), rounded(*y));
        if i == 0 { data.move_to(place) } else { data.line_to(place) }
    })
}

/// A hundredth of a pixel is finer than any screen.
fn rounded(pixels: f64) -> f64 {
    (pixels * 100.0).round() / 100.0
}

/// A range of values with marks, linear or logarithmic.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Axis {
    pub(crate) low: f64,
    pub(crate) high: f64,
    pub(crate) logarithmic: bool,
    pub(crate) marks: Vec<f64>,
    /// Distance of linear marks, for their decimals.
    pub(crate) step: f64,
}

impl Axis {
    /// Some `count` round marks over a range, which is exactly that of the axis.
    pub(crate) fn linear(low: f64, high: f64, count: f64) -> Self {
        Self::in_steps(low, high, round_step((high - low) / count))
    }

    fn in_steps(low: f64, high: f64, step: f64) -> Self {
        let (first, last) = ((low / step - 1e-9).ceil(), (high / step + 1e-9).floor());
        let marks = (0_u32..).map(|i| first + f64::from(i)).take_while(|i| *i <= last).map(|i| i * step).collect();
        Self { low, high, logarithmic: false, marks, step }
    }

    /// The same, widened to end on marks.
    pub(crate) fn linear_to_marks(low: f64, high: f64, count: f64) -> Self {
        let high = if high > low { high } else { low + low.abs().max(1e-3) };
        let step = round_step((high - low) / count);
        Self::in_steps((low / step + 1e-9).floor() * step, (high / step - 1e-9).ceil() * step, step)
    }

    /// Powers of ten, or 1, 2 and 5 times these if they are few.
    pub(crate) fn logarithmic(low: f64, high: f64) -> Self {
        let decades = (high / low).log10();
        let factors: &[f64] = if decades > 3.5 { &[1.0] } else { &[1.0, 2.0, 5.0] };
        let apart = (decades / 8.0).ceil().max(1.0);
        let exponents = (0_u32..).map(|i| low.log10().floor() + f64::from(i)).take_while(|e| *e <= high.log10());
        let marks = exponents
            .filter(|exponent| (exponent / apart).fract().abs() < 1e-9)
            .flat_map(|exponent| factors.iter().map(move |factor| factor * 10_f64.powf(exponent)))
            .filter(|mark| (low * 0.999..=high * 1.001).contains(mark))
            .collect();
        Self { low, high, logarithmic: true, marks, step: 0.0 }
    }

    /// Where a value lies between both ends, 0–1; what lies beyond stays at the end.
    pub(crate) fn share(&self, value: f64) -> f64 {
        let share = if self.logarithmic {
            (value.max(f64::MIN_POSITIVE) / self.low).ln() / (self.high / self.low).ln()
        } else {
            (value - self.low) / (self.high - self.low)
        };
        share.clamp(0.0, 1.0)
    }

    pub(crate) fn label(&self, mark: f64) -> String {
        let (size, least) = if self.logarithmic { (mark, self.low) } else { (self.step, self.step) };
        if least < 0.999e-4 && mark != 0.0 {
            return power_of_ten(mark);
        }
        let decimals = if size < 1.0 { -(size * 1.001).log10().floor() } else { 0.0 };
        #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "0 ≤ decimals ≤ 4")]
        let decimals = decimals as usize;
        format!("{mark:.decimals$}").replace('-', "−")
    }
}

/// The next of 1, 2, 5 times a power of ten.
fn round_step(step: f64) -> f64 {
    let power = 10_f64.powf(step.log10().floor());
    let factor = [1.0, 2.0, 5.0].into_iter().find(|factor| step <= factor * power * 1.001).unwrap_or(10.0);
    factor * power
}

/// 3·10⁻⁷ for 3e-7, and 1 for 1.
fn power_of_ten(value: f64) -> String {
    let digits = format!("{value:.1e}");
    let (factor, exponent) = digits.split_once('e').unwrap_or((&digits, "0"));
    let raised = |digit: char| match digit {
        '-' => '⁻',
        '1' => '¹',
        '2' => '²',
        '3' => '³',
        _ => char::from_u32(0x2070 + digit.to_digit(10).unwrap_or(0)).unwrap_or(digit),
    };
    let power: String = exponent.chars().map(raised).collect();
    match factor.trim_end_matches(".0") {
        "1" if exponent == "0" => "1".to_owned(),
        "1" => format!("10{power}"),
        factor => format!("{factor}·10{power}"),
    }
}

/// A colour for step `i` of `count` ordered things.
pub(crate) fn ordered_colour(i: usize, count: usize) -> String {
    const VIRIDIS: [[f64; 3]; 4] = [[68.0, 1.0, 84.0], [59.0, 82.0, 139.0], [33.0, 145.0, 140.0], [94.0, 201.0, 98.0]];
    let share = if count > 1 { i as f64 / (count - 1) as f64 } else { 0.3 };
    #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "0 ≤ share ≤ 1")]
    let cell = ((share * 3.0) as usize).min(2);
    let t = share * 3.0 - cell as f64;
    let mix = |channel: usize| VIRIDIS[cell][channel] * (1.0 - t) + VIRIDIS[cell + 1][channel] * t;
    format!("rgb({:.0},{:.0},{:.0})", mix(0), mix(1), mix(2))
}

/// The colour of light of one wavelength, dark enough for a line on white; grey where the eye sees nothing.
fn wavelength_colour(wavelength_nm: f64) -> String {
    const DARKEST_AND_LIGHTEST_NM: (f64, f64) = (390.0, 740.0);
    const BRIGHTEST: f64 = 0.3;
    let visible = (DARKEST_AND_LIGHTEST_NM.0..=DARKEST_AND_LIGHTEST_NM.1).contains(&wavelength_nm);
    match Observer::Cie1931.color_matching(wavelength_nm) {
        Ok(xyz) if visible => {
            // No screen shows these: what it lacks is cut off, since a line should be as colourful as can be.
            let LinearRgb { r, g, b } = LinearRgb::from_xyz(xyz);
            let shown = LinearRgb { r: r.max(0.0), g: g.max(0.0), b: b.max(0.0) };
            let brightness = shown.r.max(shown.g).max(shown.b).max(shown.luminance() / BRIGHTEST);
            let scaled = [shown.r, shown.g, shown.b].map(|channel| channel / brightness);
            Srgb8::encode(LinearRgb { r: scaled[0], g: scaled[1], b: scaled[2] }).to_string()
        }
        _ => GREY.to_owned(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn axes_end_on_round_marks() {
        let axis = Axis::linear_to_marks(0.0, 0.0437, 4.0);
        assert_eq!((axis.share(0.0), axis.label(axis.high)), (0.0, "0.06".to_owned()));
        let axis = Axis::linear_to_marks(0.8785, 0.8985, 4.0);
        assert_eq!((axis.label(axis.low), axis.label(axis.high)), ("0.875".to_owned(), "0.900".to_owned()));
        let labels = |axis: &Axis| axis.marks.iter().map(|mark| axis.label(*mark)).collect::<Vec<_>>();
        assert_eq!(labels(&Axis::linear(400.0, 700.0, 6.0)), ["400", "450", "500", "550", "600", "650", "700"]);
        assert_eq!(labels(&Axis::logarithmic(0.01, 0.5)), ["0.01", "0.02", "0.05", "0.1", "0.2", "0.5"]);
        assert_eq!(labels(&Axis::logarithmic(1e-4, 1.0)), ["0.0001", "0.001", "0.01", "0.1", "1"]);
        assert_eq!(labels(&Axis::logarithmic(1e-5, 1.0)), ["10⁻⁵", "10⁻⁴", "10⁻³", "10⁻²", "10⁻¹", "1"]);
        assert!(labels(&Axis::logarithmic(1e-30, 1.0)).len() < 10);
        assert_eq!(power_of_ten(2.5e-12), "2.5·10⁻¹²");
    }

    #[test]
    fn wavelengths_have_their_colours() {
        let channels = |nm: f64| wavelength_colour(nm).parse::<Srgb8>().unwrap();
        let (blue, green, red) = (channels(460.0), channels(535.0), channels(650.0));
        assert!(blue.b > blue.g && green.g > green.r.max(green.b) && red.r > red.g.max(red.b));
        assert_eq!(wavelength_colour(1500.0), GREY);
    }
}
