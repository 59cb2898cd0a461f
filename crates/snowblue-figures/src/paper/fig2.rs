//! The paper's Fig. 2 drawn anew: light in a section of snow, followed by the laws of Fresnel and Snell, and the facets
//! that make a grain's surface rough.

use std::f64::consts::TAU;

use glam::DVec2;
use snowblue_transport::grain::ROUGHNESS_PER_FACETNESS;
use snowblue_transport::optics::Ice;
use snowblue_transport::optics::fresnel;
use snowblue_transport::rng::Stream;

use crate::error::FigureError;
use crate::figure::{Drawing, Figure};
use crate::plot::{Canvas, GREY, INK, LABEL, Lettering, Point, Stroke};
use crate::table::{Cell, DataTable};

const WAVELENGTH_NM: f64 = 550.0;
const SEED: u64 = 5;
/// The section: its size, and the grains that are tried in it, in mm.
const SECTION_MM: DVec2 = DVec2::new(6.2, 3.7);
const LONG_MM: (f64, f64) = (0.36, 0.72);
const TRIES: usize = 12_000;
/// Air that is left between grains, in mm.
const GAP_MM: f64 = 0.025;
/// Range of sphericity, as that of natural rounded snow.
const SPHERICITY: (f64, f64) = (0.7, 0.9);
const INCIDENCE_DEG: f64 = 20.0;
/// The facetness of the enlarged surface: rough enough to be seen.
const FACETNESS: f64 = 0.9;

const AIR: &str = "#d9860a";
const IN_ICE: &str = "#1f6feb";
const ICE: &str = "#dcebf7";
const EDGE: &str = "#8fb3d1";

/// A spheroid cut along its axis, in mm.
struct Grain {
    centre: DVec2,
    /// Unit vector along the long axis.
    axis: DVec2,
    long: f64,
    short: f64,
}

/// A ray's way through the section: its corners, each with whether the way to it led through ice.
struct Way {
    corners: Vec<(DVec2, bool)>,
    end: End,
}

#[derive(Clone, Copy, PartialEq)]
enum End {
    Above,
    Below,
    Aside,
}

pub(crate) fn figure() -> Result<Figure, FigureError> {
    let index = Ice::warren_brandt_2008().index(WAVELENGTH_NM);
    let grains = grains();
    let ways = ways(&grains, index)?;
    let ice: f64 = grains.iter().map(|grain| 0.25 * std::f64::consts::PI * grain.long * grain.short).sum();
    let rows = ways.iter().enumerate().flat_map(|(number, way)| {
        way.corners.iter().map(move |(place, inside)| {
            let medium = Cell::Word(if *inside { "ice" } else { "air" }.to_owned());
            vec![(number as f64 + 1.0).into(), place.x.into(), place.y.into(), medium]
        })
    });
    Ok(Figure {
        title: "Light in snow",
        ours: format!(
            "A section of snow and three rays in it, computed: {} rounded grains are placed at random without overlap (ice \
             fills {:.0} % of the section), and each ray is reflected or refracted wherever it meets ice, by Fresnel's and \
             Snell's laws with n = {index:.3}. In snow the grains touch in three dimensions; our engines take them as spheroids in \
             random orientation. Right: a surface of facetness {FACETNESS}, its facets drawn from the GGX slopes that the engines \
             use (α = {:.3}), with the normals m of the facets and n of the grain.",
            grains.len(),
            100.0 * ice / (SECTION_MM.x * SECTION_MM.y),
            ROUGHNESS_PER_FACETNESS * FACETNESS,
        ),
        paper: "Sketches light that traverses a sample of rounded grains, and in an inset a surface of microfacets with their \
                normals. This is not a copy of that drawing."
            .to_owned(),
        drawing: Drawing::Svg(draw(&grains, &ways, index)?),
        numbers: DataTable::new(&["ray", "x_mm", "y_mm", "through"], rows.collect()),
        tables: Vec::new(),
        warning: None,
    })
}

impl Grain {
    /// A place in the frame in which the grain is the unit circle, and a direction likewise.
    fn stretched(&self, v: DVec2) -> DVec2 {
        DVec2::new(v.dot(self.axis) / (0.5 * self.long), v.dot(self.axis.perp()) / (0.5 * self.short))
    }

    /// Points around the edge, moved outwards by some air.
    fn edge(&self, air: f64) -> impl Iterator<Item = DVec2> + '_ {
        const STEPS: u32 = 40;
        (0..STEPS).map(move |step| {
            let (sine, cosine) = (TAU * f64::from(step) / f64::from(STEPS)).sin_cos();
            let (long, short) = (0.5 * self.long + air, 0.5 * self.short + air);
            self.centre + self.axis * (long * cosine) + self.axis.perp() * (short * sine)
        })
    }

    fn holds(&self, place: DVec2) -> bool {
        self.stretched(place - self.centre).length_squared() <= 1.0
    }

    /// Outward normal at a place on the edge.
    fn normal(&self, place: DVec2) -> DVec2 {
        let at = self.stretched(place - self.centre);
        (self.axis * (at.x / self.long) + self.axis.perp() * (at.y / self.short)).normalize()
    }

    /// How far a ray goes until it meets the edge.
    fn distance(&self, from: DVec2, direction: DVec2) -> Option<f64> {
        const STARTED: f64 = 1e-9;
        let (p, d) = (self.stretched(from - self.centre), self.stretched(direction));
        let (a, b, c) = (d.length_squared(), p.dot(d), p.length_squared() - 1.0);
        let square = b * b - a * c;
        let root = (square >= 0.0).then(|| square.sqrt())?;
        [(-b - root) / a, (-b + root) / a].into_iter().find(|distance| *distance > STARTED)
    }
}

/// Grains placed one after the other wherever there is room.
fn grains() -> Vec<Grain> {
    let mut stream = Stream::new(SEED, 0);
    let mut grains: Vec<Grain> = Vec::new();
    for _ in 0..TRIES {
        let mut between = |(low, high): (f64, f64)| low + (high - low) * stream.uniform();
        let (long, sphericity) = (between(LONG_MM), between(SPHERICITY));
        let centre = DVec2::new(between((0.0, SECTION_MM.x)), between((0.0, SECTION_MM.y)));
        let axis = DVec2::from_angle(between((0.0, TAU)));
        let grain = Grain { centre, axis, long, short: long * sphericity * sphericity };
        let within = |place: DVec2| place.cmpge(DVec2::ZERO).all() && place.cmple(SECTION_MM).all();
        let apart = |other: &Grain| {
            !grain.edge(GAP_MM).any(|place| other.holds(place)) && !other.edge(GAP_MM).any(|place| grain.holds(place))
        };
        if grain.edge(0.0).all(within) && grains.iter().all(apart) {
            grains.push(grain);
        }
    }
    grains
}

/// Three rays that tell the story: one comes back, two pass.
fn ways(grains: &[Grain], index: f64) -> Result<Vec<Way>, FigureError> {
    const MEETINGS: std::ops::RangeInclusive<usize> = 10..=44;
    // Where each enters and leaves, as shares of the width.
    let wanted = [
        ((0.08, 0.22), End::Below, (0.02, 0.34)),
        ((0.36, 0.5), End::Above, (0.48, 0.57)),
        ((0.78, 0.88), End::Below, (0.62, 0.94)),
    ];
    let chosen = |(enters, end, leaves): ((f64, f64), End, (f64, f64))| {
        (1..60_000_u32)
            .map(|ray| {
                let share = f64::from(ray % 101) / 101.0;
                follow(grains, index, SECTION_MM.x * (enters.0 + (enters.1 - enters.0) * share), u64::from(ray))
            })
            .find(|way| {
                let last = way.corners[way.corners.len() - 1].0.x / SECTION_MM.x;
                let deep = way.corners.iter().any(|(place, _)| place.y > 0.55 * SECTION_MM.y);
                let fits = way.end == end && MEETINGS.contains(&way.corners.len()) && deep == (end == End::Below);
                fits && (leaves.0..leaves.1).contains(&last)
            })
            .ok_or_else(|| FigureError::Geometry("no ray goes through the section of snow as it should"))
    };
    wanted.into_iter().map(chosen).collect()
}

fn follow(grains: &[Grain], index: f64, across: f64, ray: u64) -> Way {
    const MOST: usize = 60;
    let mut stream = Stream::new(SEED, ray);
    let mut direction = DVec2::from_angle((90.0 - INCIDENCE_DEG).to_radians());
    let mut place = DVec2::new(across, 0.0) - direction * 0.55;
    let mut inside: Option<&Grain> = None;
    let mut corners = vec![(place, false)];
    for _ in 0..MOST {
        let met = match inside {
            Some(grain) => grain.distance(place, direction).map(|distance| (distance, grain)),
            None => grains
                .iter()
                .filter_map(|grain| Some((grain.distance(place, direction)?, grain)))
                .min_by(|a, b| a.0.total_cmp(&b.0)),
        };
        let Some((distance, grain)) = met else { break };
        place += direction * distance;
        corners.push((place, inside.is_some()));
        let outward = grain.normal(place);
        let (facing, relative) = if inside.is_some() { (-outward, 1.0 / index) } else { (outward, index) };
        let (reflected, refracted) = split(direction, facing, relative);
        match refracted {
            Some((refracted, share)) if stream.uniform() < share => {
                direction = refracted;
                inside = if inside.is_some() { None } else { Some(grain) };
            }
            _ => direction = reflected,
        }
    }
    let end = match direction {
        _ if inside.is_some() => End::Aside,
        direction if direction.y < 0.0 => End::Above,
        _ => End::Below,
    };
    let height = if end == End::Above { -0.42 } else { SECTION_MM.y + 0.42 };
    let last = place + direction * ((height - place.y) / direction.y);
    corners.push((last, false));
    let aside = !(0.1..SECTION_MM.x - 0.1).contains(&last.x);
    Way { corners, end: if aside { End::Aside } else { end } }
}

/// Reflection and refraction at a surface whose normal faces the light: both directions, and the refracted share.
fn split(direction: DVec2, normal: DVec2, relative_index: f64) -> (DVec2, Option<(DVec2, f64)>) {
    let cosine = -direction.dot(normal);
    let law = fresnel(cosine, relative_index);
    let reflected = direction + normal * (2.0 * cosine);
    let refracted = direction / relative_index + normal * (cosine / relative_index - law.cos_refraction);
    (reflected, (law.reflectance < 1.0).then_some((refracted, 1.0 - law.reflectance)))
}

/// Where the section and the enlarged surface lie, in pixels.
const CORNER: DVec2 = DVec2::new(40.0, 122.0);
const PIXELS_PER_MM: f64 = 94.0;
const SURFACE: [DVec2; 2] = [DVec2::new(700.0, 122.0), DVec2::new(1020.0, 470.0)];

fn draw(grains: &[Grain], ways: &[Way], index: f64) -> Result<String, FigureError> {
    let mut canvas = Canvas::new(1060.0, 566.0, "Light in snow: a section, and a grain's surface");
    let at = |place: DVec2| -> Point { (CORNER + place * PIXELS_PER_MM).into() };
    let bounds = [DVec2::ZERO, DVec2::new(SECTION_MM.x, 0.0), SECTION_MM, DVec2::new(0.0, SECTION_MM.y)].map(at);
    canvas.polygon(&bounds, "#f7f9fb", Stroke::solid("#d5dde5", 1.0));
    for grain in grains {
        let edge: Vec<Point> = grain.edge(0.0).map(at).collect();
        canvas.polygon(&edge, ICE, Stroke::solid(EDGE, 1.0));
    }
    for way in ways {
        draw_way(&mut canvas, way, &at);
    }
    let small = Lettering { size: 12.0, fill: GREY, ..LABEL };
    let bold = Lettering { bold: true, ..LABEL };
    for (way, words) in ways.iter().zip(["passes", "comes back", "passes"]) {
        let (x, y) = at(way.corners[way.corners.len() - 1].0);
        canvas.text((x + 10.0, y + if way.end == End::Above { 8.0 } else { 2.0 }), words, bold);
    }
    let (x, y) = at(ways[0].corners[0].0);
    canvas.text((x + 12.0, y + 10.0), "light in", bold);
    let (x, y) = at(SECTION_MM);
    canvas.line((x - PIXELS_PER_MM, y + 20.0), (x, y + 20.0), Stroke::solid(INK, 2.0));
    canvas.text((x, y + 38.0), "1 mm", Lettering { anchor: "end", ..small });
    let [upper, lower] = SURFACE;
    for (words, colour, left) in [("light in air", AIR, upper.x), ("light in ice", IN_ICE, upper.x + 140.0)] {
        canvas.line((left, lower.y + 24.0), (left + 28.0, lower.y + 24.0), Stroke::solid(colour, 2.2));
        canvas.text((left + 36.0, lower.y + 28.0), words, small);
    }
    // The grain whose edge is enlarged lies far to the right.
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

fn draw_way(canvas: &mut Canvas, way: &Way, at: &dyn Fn(DVec2) -> Point) {
    let last = way.corners.len() - 2;
    for (number, pair) in way.corners.windows(2).enumerate() {
        let stroke = Stroke::solid(if pair[1].1 { IN_ICE } else { AIR }, 1.8);
        let ends = [at(pair[0].0), at(pair[1].0)];
        if number == 0 {
            // The head of the first arrow lies where the light meets the section's upper edge.
            let surface = pair[0].0 + (pair[1].0 - pair[0].0) * (-pair[0].0.y / (pair[1].0.y - pair[0].0.y));
            canvas.arrow(ends[0], at(surface), stroke);
        }
        if number == last { canvas.arrow(ends[0], ends[1], stroke) } else { canvas.line(ends[0], ends[1], stroke) }
    }
}

/// Corners of a rough surface seen in section, from left to right about height 0, with facets of equal width and slopes
/// s = α √(u/(1−u)) cos φ: so a plane cuts the facets of a GGX surface (Walter et al. 2007,
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
    // A chain of random slopes drifts: its chord becomes the horizon.
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
    let words = |canvas: &mut Canvas, place: DVec2, words: &str, fill: &'static str| {
        canvas.text(place.into(), words, Lettering { fill, bold: true, ..LABEL });
    };
    let (from, direction) = (DVec2::new(upper.x + 40.0, upper.y + 28.0), DVec2::from_angle(50_f64.to_radians()));
    let met = |pair: &[DVec2]| {
        let along = pair[1] - pair[0];
        let area = direction.perp_dot(along);
        let share = (pair[0] - from).perp_dot(direction) / area;
        let distance = (pair[0] - from).perp_dot(along) / area;
        (area.abs() > 1e-12 && (0.0..=1.0).contains(&share) && distance > 0.0).then_some((distance, normal(pair)))
    };
    let first = edge.windows(2).filter_map(met).min_by(|a, b| a.0.total_cmp(&b.0));
    let (distance, facing) = first.ok_or_else(|| FigureError::Geometry("the ray misses the enlarged surface"))?;
    let hit = from + direction * distance;
    let (reflected, refracted) = split(direction, facing, index);
    canvas.arrow(from.into(), hit.into(), Stroke::solid(AIR, 2.4));
    canvas.arrow(hit.into(), (hit + reflected * 130.0).into(), Stroke::solid(AIR, 1.4));
    let share = refracted.map_or(0.0, |(_, share)| share);
    words(canvas, hit + reflected * 130.0 + DVec2::new(-38.0, -10.0), &format!("{:.1} %", 100.0 * (1.0 - share)), AIR);
    if let Some((refracted, share)) = refracted {
        canvas.arrow(hit.into(), (hit + refracted * 150.0).into(), Stroke::solid(IN_ICE, 2.4));
        words(canvas, hit + refracted * 150.0 + DVec2::new(10.0, 2.0), &format!("{:.1} %", 100.0 * share), IN_ICE);
    }
    let grain_normal = DVec2::new(edge[edge.len() - 3].x, middle);
    canvas.arrow(grain_normal.into(), (grain_normal - DVec2::Y * 84.0).into(), Stroke::solid(INK, 1.8));
    words(canvas, grain_normal + DVec2::new(8.0, -74.0), "n", INK);
    let of_facet = 0.5 * (edge[1] + edge[2]) + normal(&edge[1..3]) * 30.0;
    words(canvas, of_facet + DVec2::new(-4.0, -7.0), "m", GREY);
    words(canvas, DVec2::new(upper.x + 14.0, lower.y - 16.0), "ice", "#3f6d94");
    words(canvas, DVec2::new(lower.x - 38.0, upper.y + 22.0), "air", GREY);
    canvas.text((upper.x, upper.y - 12.0), &format!("A grain's surface, facetness {FACETNESS}"), LABEL);
    Ok(())
}
