//! A chart as SVG: panels with two axes, lines, bands, dots, rectangles, text and a legend, in pixels.

use snowblue_color::Srgb8;
use svg::node::element::path::Data;
use svg::node::element::{Circle, Path, Rectangle, Text, Title};
use svg::{Document, Node};

use super::axis::Axis;

pub(crate) const INK: &str = "#1f2933";
pub(crate) const GREY: &str = "#6b7785";
pub(crate) const PALE: &str = "#e1e6eb";

/// A point of a chart, or a size: pixels to the right and down.
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
pub(crate) const HEADING: Lettering = Lettering { bold: true, ..LABEL };
pub(crate) const REMARK: Lettering = Lettering { size: 12.0, fill: GREY, ..LABEL };
pub(crate) const TICK: Lettering = Lettering { anchor: "middle", ..REMARK };

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

/// Edges of a panel.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Area {
    pub(crate) left: f64,
    pub(crate) right: f64,
    pub(crate) top: f64,
    pub(crate) bottom: f64,
}

/// Two axes on an area.
pub(crate) struct Panel {
    area: Area,
    pub(crate) x: Axis,
    pub(crate) y: Axis,
}

impl Panel {
    pub(crate) fn point(&self, (x, y): (f64, f64)) -> Point {
        let Area { left, right, top, bottom } = self.area;
        (left + (right - left) * self.x.fraction(x), bottom - (bottom - top) * self.y.fraction(y))
    }

    pub(crate) fn points(&self, values: &[(f64, f64)]) -> Vec<Point> {
        values.iter().map(|value| self.point(*value)).collect()
    }
}

/// A drawing with its size.
pub(crate) struct Chart {
    document: Document,
    width: f64,
    height: f64,
}

impl Chart {
    pub(crate) fn new(width: f64, height: f64, title: &str) -> Self {
        let document = Document::new()
            .set("font-family", "Inter, 'Helvetica Neue', Helvetica, Arial, 'DejaVu Sans', sans-serif")
            .add(Title::new(title))
            .add(Rectangle::new().set("width", "100%").set("height", "100%").set("fill", "white"));
        let mut chart = Self { document, width, height };
        chart.text((24.0, 34.0), title, Lettering { size: 17.0, ..HEADING });
        chart
    }

    pub(crate) fn text(&mut self, (x, y): Point, words: &str, style: Lettering) {
        self.document.append(lettered(words, style).set("x", rounded(x)).set("y", rounded(y)));
    }

    pub(crate) fn curve(&mut self, points: &[Point], stroke: Stroke) {
        self.curves(&[points], stroke);
    }

    /// Several curves of one style, as one shape.
    pub(crate) fn curves(&mut self, curves: &[impl AsRef<[Point]>], stroke: Stroke) {
        let data = curves.iter().fold(Data::new(), |data, points| polyline(data, points.as_ref()));
        let mut path = Path::new().set("d", data).set("fill", "none").set("stroke-linejoin", "round");
        path.assign("stroke", stroke.colour);
        path.assign("stroke-width", stroke.width);
        if !stroke.dashes.is_empty() {
            path.assign("stroke-dasharray", stroke.dashes);
        }
        self.document.append(path);
    }

    /// A filled area between two curves.
    pub(crate) fn band(&mut self, lower: &[Point], upper: &[Point], fill: &str, opacity: f64) {
        let outline: Vec<Point> = lower.iter().chain(upper.iter().rev()).copied().collect();
        let data = polyline(Data::new(), &outline).close();
        self.document.append(Path::new().set("d", data).set("fill", fill).set("fill-opacity", opacity));
    }

    pub(crate) fn dots(&mut self, points: &[Point], radius: f64, fill: &str) {
        for (x, y) in points {
            let circle = Circle::new().set("cx", rounded(*x)).set("cy", rounded(*y)).set("r", radius);
            self.document.append(circle.set("fill", fill));
        }
    }

    /// A filled rectangle by its upper left corner and its size.
    pub(crate) fn rectangle(&mut self, (x, y): Point, (width, height): Point, fill: Srgb8) {
        let shape = Rectangle::new().set("x", rounded(x)).set("y", rounded(y)).set("fill", fill.to_string());
        self.document.append(shape.set("width", rounded(width)).set("height", rounded(height)));
    }

    /// Draws the axes [x, y] with their names and grid lines.
    pub(crate) fn panel(&mut self, area: Area, [x, y]: [Axis; 2], names: [&str; 2]) -> Panel {
        let Area { left, right, top, bottom } = area;
        let panel = Panel { area, x, y };
        for mark in &panel.x.marks {
            let (across, _) = panel.point((*mark, panel.y.low));
            self.curve(&[(across, top), (across, bottom)], Stroke::solid(PALE, 1.0));
            self.text((across, bottom + 18.0), &panel.x.label(*mark), TICK);
        }
        for mark in &panel.y.marks {
            let (_, up) = panel.point((panel.x.low, *mark));
            self.curve(&[(left, up), (right, up)], Stroke::solid(PALE, 1.0));
            self.text((left - 8.0, up + 4.0), &panel.y.label(*mark), Lettering { anchor: "end", ..TICK });
        }
        self.curve(&[(left, top), (left, bottom), (right, bottom)], Stroke::solid(GREY, 1.0));
        let middle = Lettering { anchor: "middle", ..LABEL };
        self.text((0.5 * (left + right), bottom + 38.0), names[0], middle);
        let turn = format!("translate({} {}) rotate(-90)", rounded(left - 54.0), rounded(0.5 * (top + bottom)));
        self.document.append(lettered(names[1], middle).set("transform", turn));
        panel
    }

    /// Lines with names below each other; returns the height at which another legend can follow.
    pub(crate) fn legend(&mut self, (x, mut y): Point, title: &str, entries: &[(String, Stroke)]) -> f64 {
        if !title.is_empty() {
            self.text((x, y), title, HEADING);
            y += 19.0;
        }
        for (name, stroke) in entries {
            self.curve(&[(x, y - 4.0), (x + 28.0, y - 4.0)], *stroke);
            self.text((x + 36.0, y), name, Lettering { size: 12.0, ..LABEL });
            y += 18.0;
        }
        y + 16.0
    }

    /// The SVG file. Its last lines are the metadata.
    pub(crate) fn finish(mut self, metadata: &[(&'static str, String)]) -> String {
        const MAX_LINE: f64 = 6.0;
        let mut lines = vec![String::new()];
        for words in metadata.iter().map(|(name, value)| format!("{name} {value}")) {
            let line = lines
                .last_mut()
                .filter(|line| (line.chars().count() + words.chars().count()) as f64 * MAX_LINE < self.width);
            match line {
                Some(line) if line.is_empty() => *line = words,
                Some(line) => *line += &format!(" · {words}"),
                None => lines.push(words),
            }
        }
        for line in lines {
            self.text((24.0, self.height - 16.0), &line, Lettering { size: 10.5, ..REMARK });
            self.height += 14.0;
        }
        let height = self.height - 14.0;
        self.document.assign("viewBox", (0.0, 0.0, self.width, height));
        self.document.assign("width", self.width);
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

fn polyline(data: Data, points: &[Point]) -> Data {
    points.iter().enumerate().fold(data, |data, (number, (x, y))| {
        let point = (rounded(*x), rounded(*y));
        if number == 0 { data.move_to(point) } else { data.line_to(point) }
    })
}

/// Rounds to a hundredth of a pixel, to keep files small.
fn rounded(pixels: f64) -> f64 {
    (pixels * 100.0).round() / 100.0
}

/// Colours of `count` ordered curves, along viridis (van der Walt & Smith 2015) from dark to light, which readers
/// with red-green colour blindness can distinguish.
pub(crate) fn ordered_colours(count: usize) -> Vec<String> {
    const VIRIDIS: [[f64; 3]; 4] = [[68.0, 1.0, 84.0], [59.0, 82.0, 139.0], [33.0, 145.0, 140.0], [94.0, 201.0, 98.0]];
    let colour = |number: usize| {
        let place = if count > 1 { 3.0 * number as f64 / (count - 1) as f64 } else { 0.9 };
        let mix = |channel: usize| -> f64 {
            VIRIDIS.iter().enumerate().map(|(i, rgb)| (1.0 - (place - i as f64).abs()).max(0.0) * rgb[channel]).sum()
        };
        format!("rgb({:.0},{:.0},{:.0})", mix(0), mix(1), mix(2))
    };
    (0..count).map(colour).collect()
}
