//! The paper's Fig. 4, redrawn: the quantities of a look-up, and the four path modes, computed for one drift of snow.

use glam::DVec2;
use snowblue_color::Colorimeter;
use snowblue_database::{PcaSnow, TableSample};

use crate::error::FigureError;
use crate::figure::{Drawing, Figure, FigureTable};
use crate::plot::{Canvas, GREY, INK, LABEL, Lettering, Point, Stroke};
use crate::shading::daylight;
use crate::table::{Cell, DataTable};

/// A drift of snow in section, its corners clockwise as seen, in cm; y points down.
const DRIFT_CM: [DVec2; 5] = [
    DVec2::new(0.0, 34.0),
    DVec2::new(7.0, 6.0),
    DVec2::new(19.0, 0.0),
    DVec2::new(33.0, 11.0),
    DVec2::new(36.0, 34.0),
];
/// The camera of the left drawing, and that of the path modes.
const CAMERA_CM: DVec2 = DVec2::new(-22.0, 12.0);
const CAMERA_ABOVE_CM: DVec2 = DVec2::new(-14.0, -10.0);
const LIGHT_CM: DVec2 = DVec2::new(46.0, -6.0);
/// Height at which the cameras' rays hit the snow, as a fraction of the visible face.
const SEEN: f64 = 0.62;
/// Where the left camera's other ray hits the ground.
const GROUND_CM: DVec2 = DVec2::new(-9.0, 34.0);
const SNOW: TableSample =
    TableSample { grain_size_um: 400.0, facetness: 0.3, density_kg_m3: 300.0, properties: Vec::new() };

const SNOW_FILL: &str = "#e6f0f8";
const SNOW_EDGE: &str = "#8fb3d1";
const SIGHT: &str = "#3b528b";
const LIT: &str = "#d9860a";
const INSIDE: &str = "#1f6feb";

/// A path through the snow, and the look-up along it.
struct SnowPath {
    name: &'static str,
    rule: &'static str,
    exit: DVec2,
    normal: DVec2,
    depth_cm: f64,
    /// From the outward normal to the light; no light arrives at 90° or more.
    angle_deg: f64,
    /// Luminance of the transmittance times the cosine, over the square of the distance in m.
    brightness: f64,
}

pub(crate) fn figure() -> Result<Figure, FigureError> {
    let paths = paths()?;
    let row = |path: &SnowPath| {
        let values = [path.depth_cm, path.angle_deg, path.exit.x, path.exit.y, path.brightness];
        std::iter::once(Cell::Word(path.name.to_owned())).chain(values.map(Cell::from)).collect()
    };
    let columns = ["path", "depth_cm", "angle_deg", "exit_x_cm", "exit_y_cm", "relative_luminance"];
    Ok(Figure {
        title: "The quantities of a look-up, and the path modes",
        ours: "Left: the quantities of a look-up. A ray of the camera hits snow at Xᵢ; a straight path of depth d \
               leads through it to the exit Xₜ, where the light is at an angle θ from the outward normal nₜ. Grain \
               size, facetness, density, d and θ give the transmitted spectrum. Right: the four path modes, computed \
               for one point of this drift (400 µm, .3, 300 kg/m³), seen from above. The path along the view may end \
               where no light arrives; the normal path is exact for a slab; the brightest is the brighter of the \
               normal path and the one towards the light."
            .to_owned(),
        paper:
            "Sketches a block of snow with primary rays r₁ and r₂, secondary rays, the depth d and the angle θ. Its \
                Algorithm 1 follows the view. This is not a copy of that drawing; the other three paths are ours."
                .to_owned(),
        drawing: Drawing::Svg(draw(&paths)),
        numbers: DataTable::new(&columns, paths.iter().map(row).collect()),
        tables: vec![look_ups(&paths)],
        warning: None,
    })
}

fn face(fraction: f64) -> DVec2 {
    DRIFT_CM[0] + (DRIFT_CM[1] - DRIFT_CM[0]) * fraction
}

/// Outward normal of the side between two corners.
fn outward(from: DVec2, to: DVec2) -> DVec2 {
    (to - from).perp().normalize() * -1.0
}

/// A point on the surface, and the outward normal there.
struct SurfacePoint {
    position: DVec2,
    normal: DVec2,
}

/// Where a path from the visible face leaves the convex drift.
fn exit_of(from: DVec2, direction: DVec2) -> SurfacePoint {
    const LEAST_DISTANCE_CM: f64 = 1e-6;
    let sides = DRIFT_CM.iter().zip(DRIFT_CM.iter().cycle().skip(1));
    let hits = sides.filter_map(|(a, b)| {
        let along = *b - *a;
        let area = direction.perp_dot(along);
        let distance = (*a - from).perp_dot(along) / area;
        let normal = outward(*a, *b);
        (direction.dot(normal) > 0.0 && distance > LEAST_DISTANCE_CM).then_some((distance, normal))
    });
    let nearest = hits.min_by(|a, b| a.0.total_cmp(&b.0)).unwrap_or((0.0, DVec2::ZERO));
    SurfacePoint { position: from + direction * nearest.0, normal: nearest.1 }
}

/// The table for one sample, and the observer.
struct LookUp {
    snow: PcaSnow,
    colorimeter: Colorimeter,
}

fn paths() -> Result<Vec<SnowPath>, FigureError> {
    let snow = PcaSnow::new(snowblue_data::embedded(), &SNOW)?;
    let look_up = LookUp { colorimeter: daylight(snow.wavelengths_nm())?, snow };
    let entry = face(SEEN);
    let inward = -outward(DRIFT_CM[0], DRIFT_CM[1]);
    let view = look_up.along("view", "along the viewing ray", entry - CAMERA_ABOVE_CM);
    let normal = look_up.along("normal", "along the inward normal", inward);
    let light = look_up.along("light", "towards the light", LIGHT_CM - entry);
    let brightest = if normal.brightness >= light.brightness {
        look_up.along("brightest", "the brighter: normal", inward)
    } else {
        look_up.along("brightest", "the brighter: light", LIGHT_CM - entry)
    };
    Ok(vec![view, normal, light, brightest])
}

impl LookUp {
    /// The look-up along a path from the visible face.
    fn along(&self, name: &'static str, rule: &'static str, direction: DVec2) -> SnowPath {
        let entry = face(SEEN);
        let SurfacePoint { position: exit, normal } = exit_of(entry, direction.normalize());
        let to_light = LIGHT_CM - exit;
        let cosine = normal.dot(to_light.normalize());
        let (depth_cm, angle_deg) = (entry.distance(exit), cosine.clamp(-1.0, 1.0).acos().to_degrees());
        let mut spectrum = vec![0.0; self.snow.wavelengths_nm().len()];
        self.snow.transmittance(single(depth_cm), single(angle_deg.min(89.0)), &mut spectrum);
        let spectrum: Vec<f64> = spectrum.into_iter().map(f64::from).collect();
        let received = cosine.max(0.0) / (to_light.length_squared() * 1e-4);
        let brightness = received * self.colorimeter.xyz(&spectrum).y;
        SnowPath { name, rule, exit, normal, depth_cm, angle_deg, brightness }
    }
}

#[expect(clippy::cast_possible_truncation, reason = "look-ups have single precision")]
fn single(value: f64) -> f32 {
    value as f32
}

fn brightest(paths: &[SnowPath]) -> f64 {
    paths.iter().map(|path| path.brightness).fold(0.0, f64::max)
}

fn look_ups(paths: &[SnowPath]) -> FigureTable {
    let brightest = brightest(paths);
    let row = |path: &SnowPath| {
        vec![
            path.name.to_owned(),
            format!("{:.1}", path.depth_cm),
            format!("{:.1}", path.angle_deg),
            format!("{:.1}", 100.0 * path.brightness / brightest),
        ]
    };
    let columns = ["path", "d (cm)", "θ (°)", "light that arrives (%)"];
    FigureTable::of_words("paths", "Four paths from one point", &columns, paths.iter().map(row).collect())
}

const TITLE: Lettering = Lettering { bold: true, ..LABEL };
const SYMBOL: Lettering = Lettering { size: 15.0, fill: INK, anchor: "start", bold: true };
const SMALL: Lettering = Lettering { size: 12.0, fill: GREY, ..LABEL };

fn draw(paths: &[SnowPath]) -> String {
    let mut canvas = Canvas::new(1100.0, 582.0, "The quantities of a look-up, and the path modes");
    quantities(&mut canvas);
    let brightest = brightest(paths);
    for (number, path) in paths.iter().enumerate() {
        let corner = DVec2::new(640.0 + 225.0 * (number % 2) as f64, 80.0 + 250.0 * (number / 2) as f64);
        draw_path(&mut canvas, path, corner, brightest);
    }
    let made = [
        ("snowblue", env!("CARGO_PKG_VERSION").to_owned()),
        ("look-ups", "in the embedded table, luminance under D65".to_owned()),
        ("drawing", "ours".to_owned()),
    ];
    canvas.finish(566.0, &made)
}

fn drift(canvas: &mut Canvas, at: &dyn Fn(DVec2) -> DVec2) {
    let corners = DRIFT_CM.map(|corner| at(corner).into());
    canvas.polygon(&corners, SNOW_FILL, Stroke::solid(SNOW_EDGE, 1.4));
}

/// A lamp with short rays around it.
fn lamp(canvas: &mut Canvas, centre: DVec2, radius: f64) {
    canvas.dot(centre.into(), radius, LIT);
    for step in 0..8 {
        let ray = DVec2::from_angle(f64::from(step) * std::f64::consts::FRAC_PI_4);
        canvas.line(
            (centre + ray * (1.5 * radius)).into(),
            (centre + ray * (2.1 * radius)).into(),
            Stroke::solid(LIT, 1.6),
        );
    }
}

fn camera(canvas: &mut Canvas, centre: DVec2) {
    let corner = |x: f64, y: f64| -> Point { (centre + DVec2::new(x, y)).into() };
    canvas.polygon(
        &[corner(-34.0, -13.0), corner(-6.0, -13.0), corner(-6.0, 13.0), corner(-34.0, 13.0)],
        INK,
        Stroke::solid(INK, 1.0),
    );
    canvas.polygon(
        &[corner(-6.0, -4.0), corner(4.0, -10.0), corner(4.0, 10.0), corner(-6.0, 4.0)],
        INK,
        Stroke::solid(INK, 1.0),
    );
}

/// The scene with the symbols of all quantities.
fn quantities(canvas: &mut Canvas) {
    const SCALE: f64 = 7.6;
    let at = |position: DVec2| DVec2::new(232.0, 176.0) + position * SCALE;
    let (ground, lamp_at, camera_at) = (at(GROUND_CM), at(LIGHT_CM), at(CAMERA_CM));
    canvas.text((24.0, 66.0), "The quantities of a look-up", TITLE);
    canvas.line((24.0, ground.y), (600.0, ground.y), Stroke::solid(GREY, 1.4));
    drift(canvas, &at);
    camera(canvas, camera_at);
    canvas.text((camera_at + DVec2::new(-34.0, -22.0)).into(), "camera", SMALL);
    lamp(canvas, lamp_at, 9.0);
    canvas.text((lamp_at + DVec2::new(-12.0, -26.0)).into(), "light", SMALL);
    // A primary ray to the ground, and a secondary ray from there to the snow.
    let target = at(face(0.2));
    canvas.arrow(camera_at.into(), ground.into(), Stroke::solid(SIGHT, 1.6));
    canvas.arrow(ground.into(), target.into(), Stroke { colour: SIGHT, width: 1.6, dashes: "6 4" });
    canvas.text((0.55 * camera_at + 0.45 * ground + DVec2::new(-26.0, 8.0)).into(), "r₁", SYMBOL);
    canvas.text((0.5 * (ground + target) + DVec2::new(-8.0, -12.0)).into(), "l₁", SYMBOL);
    let SurfacePoint { position: exit_cm, normal } = exit_of(face(SEEN), (face(SEEN) - CAMERA_CM).normalize());
    let (entry, exit) = (at(face(SEEN)), at(exit_cm));
    canvas.arrow(camera_at.into(), entry.into(), Stroke::solid(SIGHT, 1.6));
    canvas.text((0.5 * (camera_at + entry) + DVec2::new(-6.0, -10.0)).into(), "r₂", SYMBOL);
    draw_look_up(canvas, [entry, exit], normal, lamp_at, 70.0);
    canvas.text((entry + DVec2::new(8.0, -10.0)).into(), "Xᵢ", SYMBOL);
    canvas.text((0.5 * (entry + exit) + DVec2::new(-6.0, -8.0)).into(), "d", Lettering { fill: INSIDE, ..SYMBOL });
    canvas.text((exit + DVec2::new(-30.0, 20.0)).into(), "Xₜ", SYMBOL);
    canvas.text((exit + normal * 78.0 + DVec2::new(2.0, 8.0)).into(), "nₜ", SYMBOL);
    let bisector = (normal + (lamp_at - exit).normalize()).normalize();
    canvas.text((exit + bisector * 46.0 + DVec2::new(-3.0, 6.0)).into(), "θ", SYMBOL);
    canvas.text((at(DVec2::new(16.0, 29.0))).into(), "snow", Lettering { fill: "#4d7ea8", ..SYMBOL });
    canvas.text((24.0, 496.0), "grain size, facetness, density, d, θ  →  transmitted spectrum T(λ)", LABEL);
}

/// The path in the snow, the normal at its exit, and the light with its angle.
fn draw_look_up(canvas: &mut Canvas, [entry, exit]: [DVec2; 2], normal: DVec2, lamp_at: DVec2, length: f64) {
    let to_light = lamp_at - exit;
    canvas.line(exit.into(), lamp_at.into(), Stroke { colour: LIT, width: 1.4, dashes: "5 4" });
    canvas.arrow(exit.into(), (exit + normal * length).into(), Stroke::solid(INK, 1.5));
    let (from, to) = (normal.to_angle(), normal.to_angle() + normal.angle_to(to_light));
    canvas.arc(exit.into(), 0.45 * length, from..to, Stroke::solid(LIT, 1.4));
    canvas.line(entry.into(), exit.into(), Stroke::solid(INSIDE, 2.6));
    canvas.dot(entry.into(), 4.0, INK);
    canvas.dot(exit.into(), 4.0, INSIDE);
}

/// One path mode, in a small scene.
fn draw_path(canvas: &mut Canvas, path: &SnowPath, corner: DVec2, brightest: f64) {
    const SCALE: f64 = 2.9;
    let at = |position: DVec2| corner + DVec2::new(58.0, 46.0) + position * SCALE;
    canvas.text((corner + DVec2::new(0.0, -14.0)).into(), path.name, TITLE);
    canvas.text((corner + DVec2::new(0.0, 3.0)).into(), path.rule, SMALL);
    drift(canvas, &at);
    let (entry, exit, lamp_at) = (at(face(SEEN)), at(path.exit), at(LIGHT_CM));
    let sight = (face(SEEN) - CAMERA_ABOVE_CM).normalize();
    canvas.arrow((entry - sight * 52.0).into(), entry.into(), Stroke::solid(SIGHT, 1.4));
    lamp(canvas, lamp_at, 4.0);
    draw_look_up(canvas, [entry, exit], path.normal, lamp_at, 24.0);
    let words = format!("d = {:.1} cm, θ = {:.0}°", path.depth_cm, path.angle_deg);
    canvas.text((corner + DVec2::new(0.0, 186.0)).into(), &words, Lettering { size: 12.0, ..LABEL });
    let arrives = if path.brightness > 0.0 {
        format!("light that arrives: {:.0} %", 100.0 * path.brightness / brightest)
    } else {
        "light that arrives: none".to_owned()
    };
    canvas.text((corner + DVec2::new(0.0, 202.0)).into(), &arrives, SMALL);
}
