//! The paper's Fig. 2, redrawn: rays traced through a section of snow by Fresnel's and Snell's laws, and the facets of
//! a rough grain surface.

use std::f64::consts::TAU;
use std::ops::{Range, RangeInclusive};

use glam::DVec2;
use snowblue_transport::grain::ROUGHNESS_PER_FACETNESS;
use snowblue_transport::optics::IceTable;
use snowblue_transport::optics::fresnel;
use snowblue_transport::rng::Stream;

use crate::error::FigureError;
use crate::figure::{Drawing, Figure};
use crate::plot::{Canvas, GREY, INK, LABEL, Lettering, Point, Stroke};
use crate::table::{Cell, DataTable};

const WAVELENGTH_NM: f64 = 550.0;
const SEED: u64 = 5;
/// Size of the section, and range of the grains' long axes, in mm.
const SECTION_MM: DVec2 = DVec2::new(6.2, 3.7);
const LONG_MM: (f64, f64) = (0.36, 0.72);
/// Attempts to place a grain.
const ATTEMPTS: usize = 12_000;
/// Least gap between grains, in mm.
const GAP_MM: f64 = 0.025;
/// Range of sphericity of rounded natural snow.
const SPHERICITY: (f64, f64) = (0.7, 0.9);
const INCIDENCE_DEG: f64 = 20.0;
/// Facetness of the magnified surface, large enough to be visible.
const FACETNESS: f64 = 0.9;

const AIR: &str = "#d9860a";
const IN_ICE: &str = "#1f6feb";
const ICE: &str = "#dcebf7";
const EDGE: &str = "#8fb3d1";

/// A spheroid in section along its axis, in mm.
struct Grain {
    centre: DVec2,
    /// Unit vector along the long axis.
    axis: DVec2,
    long: f64,
    short: f64,
}

/// A vertex of a ray's path.
struct Vertex {
    position: DVec2,
    /// Whether the segment that ends here is in ice.
    through_ice: bool,
}

/// The path of a ray through the section.
struct RayPath {
    vertices: Vec<Vertex>,
    exit: Exit,
}

/// Where a ray leaves the section.
#[derive(Clone, Copy, PartialEq)]
enum Exit {
    Top,
    Bottom,
    /// Through a side, or not at all.
    Side,
}

/// A wanted ray: ranges of its entry and of its exit as fractions of the width, and where it leaves.
struct WantedRay {
    entry: Range<f64>,
    exit: Exit,
    leaves: Range<f64>,
}

/// A grain that a ray hits, and the distance to it.
struct Hit<'g> {
    distance: f64,
    grain: &'g Grain,
}

/// Reflected and refracted directions at a surface; no refraction under total reflection.
struct Split {
    reflected: DVec2,
    refracted: Option<Refracted>,
}

/// A refracted direction, and the fraction of the light that takes it.
struct Refracted {
    direction: DVec2,
    fraction: f64,
}

pub(crate) fn figure() -> Result<Figure, FigureError> {
    let index = IceTable::WarrenBrandt2008.index(WAVELENGTH_NM);
    let grains = grains();
    let paths = paths(&grains, index)?;
    let ice: f64 = grains.iter().map(|grain| 0.25 * std::f64::consts::PI * grain.long * grain.short).sum();
    let rows = paths.iter().enumerate().flat_map(|(number, path)| {
        path.vertices.iter().map(move |Vertex { position, through_ice }| {
            let medium = Cell::word(if *through_ice { "ice" } else { "air" });
            vec![(number as f64 + 1.0).into(), position.x.into(), position.y.into(), medium]
        })
    });
    Ok(Figure {
        title: "Light in snow",
        ours: format!(
            "A section of snow with three computed rays: {} rounded grains are placed at random without overlap (ice \
             fills {:.0} % of the section), and each ray is reflected or refracted at ice surfaces by Fresnel's and \
             Snell's laws with n = {index:.3}. In real snow the grains touch in three dimensions; our engines model \
             them as randomly oriented spheroids. Right: a surface of facetness {FACETNESS}, its facets drawn from the \
             GGX slopes of the engines (α = {:.3}), with the normals m of the facets and n of the grain.",
            grains.len(),
            100.0 * ice / (SECTION_MM.x * SECTION_MM.y),
            ROUGHNESS_PER_FACETNESS * FACETNESS,
        ),
        paper:
            "Sketches light that traverses a sample of rounded grains, and in an inset a surface of microfacets with \
                their normals. This is not a copy of that drawing."
                .to_owned(),
        drawing: Drawing::Svg(draw(&grains, &paths, index)?),
        numbers: DataTable::new(&["ray", "x_mm", "y_mm", "through"], rows.collect()),
        tables: Vec::new(),
        warning: None,
    })
}

impl Grain {
    /// A vector in the frame in which the grain is the unit circle.
    fn to_unit_circle(&self, v: DVec2) -> DVec2 {
        DVec2::new(v.dot(self.axis) / (0.5 * self.long), v.dot(self.axis.perp()) / (0.5 * self.short))
    }

    /// Points on the edge, moved outwards by a gap.
    fn edge(&self, gap: f64) -> impl Iterator<Item = DVec2> + '_ {
        const STEPS: u32 = 40;
        (0..STEPS).map(move |step| {
            let (sine, cosine) = (TAU * f64::from(step) / f64::from(STEPS)).sin_cos();
            let (long, short) = (0.5 * self.long + gap, 0.5 * self.short + gap);
            self.centre + self.axis * (long * cosine) + self.axis.perp() * (short * sine)
        })
    }

    fn contains(&self, point: DVec2) -> bool {
        self.to_unit_circle(point - self.centre).length_squared() <= 1.0
    }

    /// Outward normal at a point on the edge.
    fn normal(&self, point: DVec2) -> DVec2 {
        let at = self.to_unit_circle(point - self.centre);
        (self.axis * (at.x / self.long) + self.axis.perp() * (at.y / self.short)).normalize()
    }

    /// Distance along a ray to the edge.
    fn distance(&self, origin: DVec2, direction: DVec2) -> Option<f64> {
        const LEAST_DISTANCE: f64 = 1e-9;
        let (p, d) = (self.to_unit_circle(origin - self.centre), self.to_unit_circle(direction));
        let (a, b, c) = (d.length_squared(), p.dot(d), p.length_squared() - 1.0);
        let square = b * b - a * c;
        let root = (square >= 0.0).then(|| square.sqrt())?;
        [(-b - root) / a, (-b + root) / a].into_iter().find(|distance| *distance > LEAST_DISTANCE)
    }
}

/// Grains at random positions without overlap.
fn grains() -> Vec<Grain> {
    let mut stream = Stream::new(SEED, 0);
    let mut grains: Vec<Grain> = Vec::new();
    for _ in 0..ATTEMPTS {
        let mut between = |(low, high): (f64, f64)| low + (high - low) * stream.uniform();
        let (long, sphericity) = (between(LONG_MM), between(SPHERICITY));
        let centre = DVec2::new(between((0.0, SECTION_MM.x)), between((0.0, SECTION_MM.y)));
        let axis = DVec2::from_angle(between((0.0, TAU)));
        let grain = Grain { centre, axis, long, short: long * sphericity * sphericity };
        let within = |point: DVec2| point.cmpge(DVec2::ZERO).all() && point.cmple(SECTION_MM).all();
        let apart = |other: &Grain| {
            !grain.edge(GAP_MM).any(|point| other.contains(point))
                && !other.edge(GAP_MM).any(|point| grain.contains(point))
        };
        if grain.edge(0.0).all(within) && grains.iter().all(apart) {
            grains.push(grain);
        }
    }
    grains
}

/// Three typical rays: one is scattered back, two pass.
fn paths(grains: &[Grain], index: f64) -> Result<Vec<RayPath>, FigureError> {
    const VERTICES: RangeInclusive<usize> = 10..=44;
    let wanted = [
        WantedRay { entry: 0.08..0.22, exit: Exit::Bottom, leaves: 0.02..0.34 },
        WantedRay { entry: 0.36..0.5, exit: Exit::Top, leaves: 0.48..0.57 },
        WantedRay { entry: 0.78..0.88, exit: Exit::Bottom, leaves: 0.62..0.94 },
    ];
    let chosen = |WantedRay { entry, exit, leaves }: WantedRay| {
        (1..60_000_u32)
            .map(|ray| {
                let fraction = f64::from(ray % 101) / 101.0;
                let x = SECTION_MM.x * (entry.start + (entry.end - entry.start) * fraction);
                trace(grains, index, x, u64::from(ray))
            })
            .find(|path| {
                let last = path.vertices[path.vertices.len() - 1].position.x / SECTION_MM.x;
                let deep = path.vertices.iter().any(|vertex| vertex.position.y > 0.55 * SECTION_MM.y);
                let fits =
                    path.exit == exit && VERTICES.contains(&path.vertices.len()) && deep == (exit == Exit::Bottom);
                fits && leaves.contains(&last)
            })
            .ok_or(FigureError::Geometry("no ray crosses the section of snow as required"))
    };
    wanted.into_iter().map(chosen).collect()
}

/// Traces a ray that enters the section at `x`.
fn trace(grains: &[Grain], index: f64, x: f64, ray: u64) -> RayPath {
    const MOST_HITS: usize = 60;
    let mut stream = Stream::new(SEED, ray);
    let mut direction = DVec2::from_angle((90.0 - INCIDENCE_DEG).to_radians());
    let mut position = DVec2::new(x, 0.0) - direction * 0.55;
    let mut inside: Option<&Grain> = None;
    let mut vertices = vec![Vertex { position, through_ice: false }];
    for _ in 0..MOST_HITS {
        let hit_of = |grain: &Grain| grain.distance(position, direction);
        let hit = match inside {
            Some(grain) => hit_of(grain).map(|distance| Hit { distance, grain }),
            None => grains
                .iter()
                .filter_map(|grain| Some(Hit { distance: hit_of(grain)?, grain }))
                .min_by(|a, b| a.distance.total_cmp(&b.distance)),
        };
        let Some(Hit { distance, grain }) = hit else { break };
        position += direction * distance;
        vertices.push(Vertex { position, through_ice: inside.is_some() });
        let outward = grain.normal(position);
        let (facing, relative) = if inside.is_some() { (-outward, 1.0 / index) } else { (outward, index) };
        let Split { reflected, refracted } = split(direction, facing, relative);
        match refracted {
            Some(Refracted { direction: refracted, fraction }) if stream.uniform() < fraction => {
                direction = refracted;
                inside = if inside.is_some() { None } else { Some(grain) };
            }
            _ => direction = reflected,
        }
    }
    let exit = match direction {
        _ if inside.is_some() => Exit::Side,
        direction if direction.y < 0.0 => Exit::Top,
        _ => Exit::Bottom,
    };
    let height = if exit == Exit::Top { -0.42 } else { SECTION_MM.y + 0.42 };
    let position = position + direction * ((height - position.y) / direction.y);
    vertices.push(Vertex { position, through_ice: false });
    let beside = !(0.1..SECTION_MM.x - 0.1).contains(&position.x);
    RayPath { vertices, exit: if beside { Exit::Side } else { exit } }
}

/// Reflection and refraction at a surface whose normal faces the light.
fn split(direction: DVec2, normal: DVec2, relative_index: f64) -> Split {
    let cosine = -direction.dot(normal);
    let law = fresnel(cosine, relative_index);
    let reflected = direction + normal * (2.0 * cosine);
    let refracted = direction / relative_index + normal * (cosine / relative_index - law.cos_refraction);
    let fraction = 1.0 - law.reflectance;
    Split { reflected, refracted: (law.reflectance < 1.0).then_some(Refracted { direction: refracted, fraction }) }
}

/// Positions of the section and of the magnified surface, in pixels.
const CORNER: DVec2 = DVec2::new(40.0, 122.0);
const PIXELS_PER_MM: f64 = 94.0;
const SURFACE: [DVec2; 2] = [DVec2::new(700.0, 122.0), DVec2::new(1020.0, 470.0)];

fn draw(grains: &[Grain], paths: &[RayPath], index: f64) -> Result<String, FigureError> {
    let mut canvas = Canvas::new(1060.0, 566.0, "Light in snow: a section, and a grain's surface");
    let at = |position: DVec2| -> Point { (CORNER + position * PIXELS_PER_MM).into() };
    let bounds = [DVec2::ZERO, DVec2::new(SECTION_MM.x, 0.0), SECTION_MM, DVec2::new(0.0, SECTION_MM.y)].map(at);
    canvas.polygon(&bounds, "#f7f9fb", Stroke::solid("#d5dde5", 1.0));
    for grain in grains {
        let edge: Vec<Point> = grain.edge(0.0).map(at).collect();
        canvas.polygon(&edge, ICE, Stroke::solid(EDGE, 1.0));
    }
    for path in paths {
        draw_path(&mut canvas, path, &at);
    }
    let small = Lettering { size: 12.0, fill: GREY, ..LABEL };
    let bold = Lettering { bold: true, ..LABEL };
    for (path, words) in paths.iter().zip(["transmitted", "reflected", "transmitted"]) {
        let (x, y) = at(path.vertices[path.vertices.len() - 1].position);
        canvas.text((x + 10.0, y + if path.exit == Exit::Top { 8.0 } else { 2.0 }), words, bold);
    }
    let (x, y) = at(paths[0].vertices[0].position);
    canvas.text((x + 12.0, y + 10.0), "light in", bold);
    let (x, y) = at(SECTION_MM);
    canvas.line((x - PIXELS_PER_MM, y + 20.0), (x, y + 20.0), Stroke::solid(INK, 2.0));
    canvas.text((x, y + 38.0), "1 mm", Lettering { anchor: "end", ..small });
    let [upper, lower] = SURFACE;
    for (words, colour, left) in [("light in air", AIR, upper.x), ("light in ice", IN_ICE, upper.x + 140.0)] {
        canvas.line((left, lower.y + 24.0), (left + 28.0, lower.y + 24.0), Stroke::solid(colour, 2.2));
        canvas.text((left + 36.0, lower.y + 28.0), words, small);
    }
    // The magnified edge is that of a grain far to the right.
    if let Some(grain) = grains.iter().max_by(|a, b| reach(a).total_cmp(&reach(b))) {
        let (x, y) = at(grain.centre + DVec2::X * (0.5 * grain.short));
        canvas.arc((x, y), 13.0, 0.0..TAU, Stroke::solid(INK, 1.2));
        for (corner, side) in [(SURFACE[0], -1.0), (DVec2::new(SURFACE[0].x, SURFACE[1].y), 1.0)] {
            canvas.line((x + 3.0, y + side * 12.6), corner.into(), Stroke { colour: GREY, width: 0.9, dashes: "3 3" });
        }
    }
    surface(&mut canvas, index)?;
    let made = [
        ("snowblue", env!("CARGO_PKG_VERSION").to_owned()),
        ("rays", format!("by Fresnel and Snell, n of ice at {WAVELENGTH_NM} nm, warren2008")),
        ("drawing", "ours".to_owned()),
    ];
    Ok(canvas.finish(550.0, &made))
}

fn reach(grain: &Grain) -> f64 {
    grain.centre.x - 0.8 * (grain.centre.y - 0.5 * SECTION_MM.y).abs()
}

fn draw_path(canvas: &mut Canvas, path: &RayPath, at: &dyn Fn(DVec2) -> Point) {
    let last = path.vertices.len() - 2;
    for (number, pair) in path.vertices.windows(2).enumerate() {
        let stroke = Stroke::solid(if pair[1].through_ice { IN_ICE } else { AIR }, 1.8);
        let ends = [at(pair[0].position), at(pair[1].position)];
        if number == 0 {
            // The first arrow ends at the top of the section.
            let (from, to) = (pair[0].position, pair[1].position);
            let surface = from + (to - from) * (-from.y / (to.y - from.y));
            canvas.arrow(ends[0], at(surface), stroke);
        }
        if number == last { canvas.arrow(ends[0], ends[1], stroke) } else { canvas.line(ends[0], ends[1], stroke) }
    }
}

/// Vertices of a rough surface in section, from left to right around height 0. The facets have equal widths and slopes
/// s = α √(u/(1−u)) cos φ, those of a plane section of a GGX surface (Walter et al. 2007,
/// doi:10.2312/EGWR/EGSR07/195-206).
fn facets() -> Vec<DVec2> {
    const COUNT: u32 = 10;
    let mut stream = Stream::new(SEED, 77);
    let mut corners = vec![DVec2::ZERO];
    for step in 1..=COUNT {
        let (u, phi) = (stream.uniform(), TAU * stream.uniform());
        let slope = ROUGHNESS_PER_FACETNESS * FACETNESS * (u / (1.0 - u)).sqrt() * phi.cos();
        let last = corners[corners.len() - 1];
        corners.push(DVec2::new(f64::from(step) / f64::from(COUNT), last.y + slope / f64::from(COUNT)));
    }
    // Random slopes drift; rotate the chord to the horizontal.
    let drift = corners[corners.len() - 1].y;
    for corner in &mut corners {
        corner.y -= drift * corner.x;
    }
    corners
}

fn surface(canvas: &mut Canvas, index: f64) -> Result<(), FigureError> {
    let [upper, lower] = SURFACE;
    let box_corners = [upper, DVec2::new(lower.x, upper.y), lower, DVec2::new(upper.x, lower.y)].map(Point::from);
    canvas.polygon(&box_corners, "#f7f9fb", Stroke::solid("#d5dde5", 1.0));
    let middle = 0.56 * upper.y + 0.44 * lower.y;
    let at =
        |corner: DVec2| DVec2::new(upper.x + (lower.x - upper.x) * corner.x, middle - (lower.x - upper.x) * corner.y);
    let edge: Vec<DVec2> = facets().into_iter().map(at).collect();
    let ice: Vec<Point> = edge.iter().copied().chain([lower, DVec2::new(upper.x, lower.y)]).map(Point::from).collect();
    canvas.polygon(&ice, ICE, Stroke::solid("none", 0.0));
    canvas.line((upper.x, middle), (lower.x, middle), Stroke { colour: GREY, width: 1.0, dashes: "5 4" });
    let line: Vec<Point> = edge.iter().copied().map(Point::from).collect();
    canvas.curve(&line, Stroke::solid("#3f6d94", 2.0));
    let normal = |pair: &[DVec2]| (pair[1] - pair[0]).normalize().perp() * -1.0;
    for pair in edge.windows(2) {
        let foot = 0.5 * (pair[0] + pair[1]);
        canvas.arrow(foot.into(), (foot + normal(pair) * 30.0).into(), Stroke::solid(GREY, 1.1));
    }
    let words = |canvas: &mut Canvas, position: DVec2, words: &str, fill: &'static str| {
        canvas.text(position.into(), words, Lettering { fill, bold: true, ..LABEL });
    };
    let (from, direction) = (DVec2::new(upper.x + 40.0, upper.y + 28.0), DVec2::from_angle(50_f64.to_radians()));
    let hit = |pair: &[DVec2]| {
        let along = pair[1] - pair[0];
        let area = direction.perp_dot(along);
        let fraction = (pair[0] - from).perp_dot(direction) / area;
        let distance = (pair[0] - from).perp_dot(along) / area;
        (area.abs() > 1e-12 && (0.0..=1.0).contains(&fraction) && distance > 0.0).then_some((distance, normal(pair)))
    };
    let first = edge.windows(2).filter_map(hit).min_by(|a, b| a.0.total_cmp(&b.0));
    let (distance, facing) = first.ok_or(FigureError::Geometry("the ray misses the magnified surface"))?;
    let hit = from + direction * distance;
    let Split { reflected, refracted } = split(direction, facing, index);
    canvas.arrow(from.into(), hit.into(), Stroke::solid(AIR, 2.4));
    canvas.arrow(hit.into(), (hit + reflected * 130.0).into(), Stroke::solid(AIR, 1.4));
    let refracted_fraction = refracted.as_ref().map_or(0.0, |refracted| refracted.fraction);
    let reflected_end = hit + reflected * 130.0;
    let percent = |fraction: f64| format!("{:.1} %", 100.0 * fraction);
    words(canvas, reflected_end + DVec2::new(-38.0, -10.0), &percent(1.0 - refracted_fraction), AIR);
    if let Some(Refracted { direction, fraction }) = refracted {
        let end = hit + direction * 150.0;
        canvas.arrow(hit.into(), end.into(), Stroke::solid(IN_ICE, 2.4));
        words(canvas, end + DVec2::new(10.0, 2.0), &percent(fraction), IN_ICE);
    }
    let grain_normal = DVec2::new(edge[edge.len() - 3].x, middle);
    canvas.arrow(grain_normal.into(), (grain_normal - DVec2::Y * 84.0).into(), Stroke::solid(INK, 1.8));
    words(canvas, grain_normal + DVec2::new(8.0, -74.0), "n", INK);
    let facet_normal_end = 0.5 * (edge[1] + edge[2]) + normal(&edge[1..3]) * 30.0;
    words(canvas, facet_normal_end + DVec2::new(-4.0, -7.0), "m", GREY);
    words(canvas, DVec2::new(upper.x + 14.0, lower.y - 16.0), "ice", "#3f6d94");
    words(canvas, DVec2::new(lower.x - 38.0, upper.y + 22.0), "air", GREY);
    canvas.text((upper.x, upper.y - 12.0), &format!("A grain's surface, facetness {FACETNESS}"), LABEL);
    Ok(())
}
