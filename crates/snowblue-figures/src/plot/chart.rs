//! Panels with two axes, and the lines, bands, dots and bars in them.

use std::ops::Range;

use super::axis::Axis;
use super::canvas::{Canvas, GREY, LABEL, Lettering, PALE, Point, Stroke, TICK};

/// A drawing of several panels.
pub(crate) struct Chart {
    canvas: Canvas,
    height: f64,
}

/// Edges of a panel, in pixels.
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
    x: Axis,
    y: Axis,
}

/// An entry of a legend.
pub(crate) struct Entry<'e> {
    pub(crate) name: &'e str,
    pub(crate) symbol: Symbol<'e>,
}

/// The symbol of an entry.
pub(crate) enum Symbol<'s> {
    Line(Stroke<'s>),
    /// A dot of a colour.
    Dot(&'s str),
    Band(Fill<'s>),
}

/// A colour with an opacity, 0–1.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Fill<'f> {
    pub(crate) colour: &'f str,
    pub(crate) opacity: f64,
}

impl Panel {
    fn point(&self, (x, y): (f64, f64)) -> Point {
        let Area { left, right, top, bottom } = self.area;
        (left + (right - left) * self.x.fraction(x), bottom - (bottom - top) * self.y.fraction(y))
    }

    fn points(&self, values: &[(f64, f64)]) -> Vec<Point> {
        values.iter().map(|value| self.point(*value)).collect()
    }

    /// The height of a value on the y axis, in pixels.
    pub(crate) fn height_of(&self, y: f64) -> f64 {
        self.point((self.x.low, y)).1
    }
}

impl Chart {
    pub(crate) fn new(width: f64, height: f64, title: &str) -> Self {
        Self { canvas: Canvas::new(width, height, title), height }
    }

    /// Draws the axes [x, y] with their names. An axis without marks has neither grid lines nor labels.
    pub(crate) fn panel(&mut self, area: Area, [x, y]: [Axis; 2], names: [&str; 2]) -> Panel {
        let Area { left, right, top, bottom } = area;
        let panel = Panel { area, x, y };
        let canvas = &mut self.canvas;
        for mark in &panel.x.marks {
            let (across, _) = panel.point((*mark, panel.y.low));
            canvas.line((across, top), (across, bottom), Stroke::solid(PALE, 1.0));
            canvas.text((across, bottom + 18.0), &panel.x.label(*mark), TICK);
        }
        for mark in &panel.y.marks {
            let (_, up) = panel.point((panel.x.low, *mark));
            canvas.line((left, up), (right, up), Stroke::solid(PALE, 1.0));
            canvas.text((left - 8.0, up + 4.0), &panel.y.label(*mark), Lettering { anchor: "end", ..TICK });
        }
        canvas.line((left, bottom), (right, bottom), Stroke::solid(GREY, 1.0));
        canvas.line((left, top), (left, bottom), Stroke::solid(GREY, 1.0));
        let middle = Lettering { anchor: "middle", ..LABEL };
        canvas.text((0.5 * (left + right), bottom + 38.0), names[0], middle);
        canvas.vertical_text((left - 48.0, 0.5 * (top + bottom)), names[1], LABEL);
        panel
    }

    pub(crate) fn line(&mut self, panel: &Panel, values: &[(f64, f64)], stroke: Stroke) {
        self.canvas.curve(&panel.points(values), stroke);
    }

    /// Lines of one style, as one shape.
    pub(crate) fn lines(&mut self, panel: &Panel, lines: &[Vec<(f64, f64)>], stroke: Stroke) {
        let points: Vec<Vec<Point>> = lines.iter().map(|values| panel.points(values)).collect();
        self.canvas.curves(&points, stroke);
    }

    /// A filled band between two curves.
    pub(crate) fn band(&mut self, panel: &Panel, [lower, upper]: [&[(f64, f64)]; 2], fill: Fill) {
        self.canvas.band(&panel.points(lower), &panel.points(upper), fill.colour, fill.opacity);
    }

    pub(crate) fn dots(&mut self, panel: &Panel, values: &[(f64, f64)], colour: &str) {
        self.sized_dots(panel, values, colour, 3.4);
    }

    /// Dots with a radius in pixels.
    pub(crate) fn sized_dots(&mut self, panel: &Panel, values: &[(f64, f64)], colour: &str, radius: f64) {
        for point in panel.points(values) {
            self.canvas.dot(point, radius, colour);
        }
    }

    /// A bar along x from the lower end of the axis to a value, over a range of y.
    pub(crate) fn bar(&mut self, panel: &Panel, value: f64, y: Range<f64>, fill: &str) {
        let (from, to) = (panel.point((panel.x.low, y.end)), panel.point((value, y.start)));
        self.swatch(from, (to.0 - from.0, to.1 - from.1), fill);
    }

    /// A filled rectangle by its upper left corner and its size, in pixels.
    pub(crate) fn swatch(&mut self, corner: Point, size: Point, fill: &str) {
        self.canvas.rectangle(corner, size, fill);
    }

    /// The bytes of a PNG file in a rectangle, by its upper left corner and its size, in pixels.
    pub(crate) fn image(&mut self, corner: Point, size: Point, png: &[u8]) {
        self.canvas.image(corner, size, png);
    }

    /// Text at a point of the canvas; `anchor` is `start`, `middle` or `end`.
    pub(crate) fn text(&mut self, point: Point, words: &str, anchor: &'static str) {
        self.canvas.text(point, words, Lettering { size: 12.0, anchor, ..LABEL });
    }

    /// A small heading.
    pub(crate) fn heading(&mut self, point: Point, words: &str) {
        self.canvas.text(point, words, Lettering { bold: true, ..LABEL });
    }

    /// Small grey text to the right of a value of a panel.
    pub(crate) fn value_text(&mut self, panel: &Panel, value: (f64, f64), words: &str) {
        let (x, y) = panel.point(value);
        self.canvas.text((x + 4.0, y), words, Lettering { size: 9.0, fill: GREY, ..LABEL });
    }

    /// Entries below each other; returns the height at which another legend can follow.
    pub(crate) fn legend(&mut self, (x, mut y): Point, title: &str, entries: &[Entry]) -> f64 {
        if !title.is_empty() {
            self.heading((x, y), title);
            y += 19.0;
        }
        for Entry { name, symbol } in entries {
            match symbol {
                Symbol::Line(stroke) => self.canvas.line((x, y - 4.0), (x + 28.0, y - 4.0), *stroke),
                Symbol::Dot(colour) => self.canvas.dot((x + 14.0, y - 4.0), 3.8, colour),
                Symbol::Band(fill) => {
                    let corners = [[(x, y - 9.0), (x + 28.0, y - 9.0)], [(x, y), (x + 28.0, y)]];
                    self.canvas.band(&corners[0], &corners[1], fill.colour, fill.opacity);
                }
            }
            self.text((x + 36.0, y), name, "start");
            y += 18.0;
        }
        y + 10.0
    }

    /// The SVG file, with a closing line of metadata.
    pub(crate) fn finish(self, metadata: &[(&'static str, String)]) -> String {
        self.canvas.finish(self.height - 16.0, metadata)
    }
}
