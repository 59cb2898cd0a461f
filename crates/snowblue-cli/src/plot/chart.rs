//! Panels with two axes and lines, bands, dots and bars in them.

use base64::Engine as _;
use base64::engine::general_purpose::STANDARD;
use svg::Node;
use svg::node::element::{Image, Rectangle};

use super::{Axis, Canvas, GREY, LABEL, Lettering, Metadata, PALE, Place, Stroke, TICK, rounded};

/// A figure of panels under the pen.
pub(crate) struct Chart {
    canvas: Canvas,
    height: f64,
}

/// Where a panel lies, in pixels.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Area {
    pub(crate) left: f64,
    pub(crate) right: f64,
    pub(crate) top: f64,
    pub(crate) bottom: f64,
}

/// One set of axes.
pub(crate) struct Panel {
    area: Area,
    x: Axis,
    y: Axis,
}

/// What a legend says of one kind of thing.
pub(crate) struct Entry<'e> {
    pub(crate) name: &'e str,
    pub(crate) look: Look<'e>,
}

/// How a thing looks.
pub(crate) enum Look<'l> {
    Line(Stroke<'l>),
    Dot(&'l str),
    /// A band or a bar of a colour and an opacity.
    Area(&'l str, f64),
}

impl Panel {
    fn place(&self, (x, y): (f64, f64)) -> Place {
        let Area { left, right, top, bottom } = self.area;
        (left + (right - left) * self.x.share(x), bottom - (bottom - top) * self.y.share(y))
    }

    fn places(&self, points: &[(f64, f64)]) -> Vec<Place> {
        points.iter().map(|point| self.place(*point)).collect()
    }
}

impl Chart {
    pub(crate) fn new((width, height): (f64, f64), title: &str) -> Self {
        Self { canvas: Canvas::new(width, height, title), height }
    }

    /// Draws the axes [x, y] with their names. An axis without marks has neither lines nor labels.
    pub(crate) fn panel(&mut self, area: Area, [x, y]: [Axis; 2], names: [&str; 2]) -> Panel {
        let Area { left, right, top, bottom } = area;
        let panel = Panel { area, x, y };
        let canvas = &mut self.canvas;
        for mark in &panel.x.marks {
            let (across, _) = panel.place((*mark, panel.y.low));
            canvas.line((across, top), (across, bottom), Stroke::full(PALE, 1.0));
            canvas.text((across, bottom + 18.0), &panel.x.label(*mark), TICK);
        }
        for mark in &panel.y.marks {
            let (_, up) = panel.place((panel.x.low, *mark));
            canvas.line((left, up), (right, up), Stroke::full(PALE, 1.0));
            canvas.text((left - 8.0, up + 4.0), &panel.y.label(*mark), Lettering { anchor: "end", ..TICK });
        }
        canvas.line((left, bottom), (right, bottom), Stroke::full(GREY, 1.0));
        canvas.line((left, top), (left, bottom), Stroke::full(GREY, 1.0));
        let middle = Lettering { anchor: "middle", ..LABEL };
        canvas.text((0.5 * (left + right), bottom + 38.0), names[0], middle);
        canvas.text_upwards((left - 48.0, 0.5 * (top + bottom)), names[1], LABEL);
        panel
    }

    pub(crate) fn line(&mut self, panel: &Panel, points: &[(f64, f64)], stroke: Stroke) {
        self.canvas.curve(&panel.places(points), stroke);
    }

    /// Lines that look alike, as one shape.
    pub(crate) fn lines(&mut self, panel: &Panel, lines: &[Vec<(f64, f64)>], stroke: Stroke) {
        let places: Vec<Vec<Place>> = lines.iter().map(|points| panel.places(points)).collect();
        self.canvas.curves(&places, stroke);
    }

    /// A filled band between two curves.
    pub(crate) fn band(&mut self, panel: &Panel, [lower, upper]: [&[(f64, f64)]; 2], (colour, opacity): (&str, f64)) {
        self.canvas.band(&panel.places(lower), &panel.places(upper), colour, opacity);
    }

    pub(crate) fn dots(&mut self, panel: &Panel, points: &[(f64, f64)], colour: &str) {
        self.dots_of(panel, points, (colour, 3.4));
    }

    /// Dots of a colour and a radius in pixels.
    pub(crate) fn dots_of(&mut self, panel: &Panel, points: &[(f64, f64)], (colour, radius): (&str, f64)) {
        for place in panel.places(points) {
            self.canvas.dot(place, radius, colour);
        }
    }

    /// A bar along x, from the lower end of the axis to a value, between two heights.
    pub(crate) fn bar(&mut self, panel: &Panel, value: f64, (low, high): (f64, f64), fill: &str) {
        let (from, to) = (panel.place((panel.x.low, high)), panel.place((value, low)));
        self.swatch(from, (to.0 - from.0, to.1 - from.1), fill);
    }

    /// A filled rectangle, its upper left corner and its size in pixels.
    pub(crate) fn swatch(&mut self, (x, y): Place, (width, height): (f64, f64), fill: &str) {
        let shape = Rectangle::new().set("x", rounded(x)).set("y", rounded(y)).set("fill", fill);
        self.canvas.0.append(shape.set("width", rounded(width)).set("height", rounded(height)));
    }

    /// A picture in a rectangle, its upper left corner and its size in pixels, from the bytes of a PNG file.
    pub(crate) fn picture(&mut self, (x, y): Place, (width, height): (f64, f64), png: &[u8]) {
        let shape = Image::new().set("x", rounded(x)).set("y", rounded(y)).set("preserveAspectRatio", "none");
        let source = format!("data:image/png;base64,{}", STANDARD.encode(png));
        self.canvas.0.append(shape.set("width", rounded(width)).set("height", rounded(height)).set("href", source));
    }

    /// Words at a place of the canvas; `anchor` is `start`, `middle` or `end`.
    pub(crate) fn words(&mut self, place: Place, words: &str, anchor: &'static str) {
        self.canvas.text(place, words, Lettering { size: 12.0, anchor, ..LABEL });
    }

    /// A small heading.
    pub(crate) fn heading(&mut self, place: Place, words: &str) {
        self.canvas.text(place, words, Lettering { bold: true, ..LABEL });
    }

    /// Small grey words just right of a value of a panel's axes.
    pub(crate) fn value(&mut self, panel: &Panel, at: (f64, f64), words: &str) {
        let (x, y) = panel.place(at);
        self.canvas.text((x + 4.0, y), words, Lettering { size: 9.0, fill: GREY, ..LABEL });
    }

    /// The height at which a value of a panel lies, in pixels.
    pub(crate) fn height_of(panel: &Panel, y: f64) -> f64 {
        panel.place((panel.x.low, y)).1
    }

    /// Entries below each other, and the height that follows.
    pub(crate) fn legend(&mut self, (x, mut y): Place, title: &str, entries: &[Entry]) -> f64 {
        if !title.is_empty() {
            self.heading((x, y), title);
            y += 19.0;
        }
        for Entry { name, look } in entries {
            match look {
                Look::Line(stroke) => self.canvas.line((x, y - 4.0), (x + 28.0, y - 4.0), *stroke),
                Look::Dot(colour) => self.canvas.dot((x + 14.0, y - 4.0), 3.8, colour),
                Look::Area(colour, opacity) => {
                    let corners = [[(x, y - 9.0), (x + 28.0, y - 9.0)], [(x, y), (x + 28.0, y)]];
                    self.canvas.band(&corners[0], &corners[1], colour, *opacity);
                }
            }
            self.words((x + 36.0, y), name, "start");
            y += 18.0;
        }
        y + 10.0
    }

    /// The figure, with a closing line that says what made it.
    pub(crate) fn finish(mut self, metadata: &Metadata) -> String {
        self.canvas.provenance(self.height - 16.0, metadata);
        format!("{}\n", self.canvas.0)
    }
}
