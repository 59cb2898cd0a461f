//! Light straight from lamps without extent, as colours from the start: a short way for pictures that ask for no more.
//!
//! Where light comes from such lamps alone and none goes from surface to surface, a point of even paint or snow has one colour
//! for each lamp, times its irradiance. The colours of snow are looked up as such
//! ([`ProjectedTable`](snowblue_database::lookup::ProjectedTable)), four numbers instead of 31 wavelengths. They are those of the long
//! way to 2·10⁻⁴. Single wavelengths in false colour go the long way: small differences of such sums would tell them apart.
//!
//! Four samples of a pixel go side by side in the [`lanes`] of registers. Those that hit the same object are lit together.

use std::f32::consts::FRAC_1_PI;

use snowblue_database::PcaSnow;
use snowblue_database::lookup::{PROJECTIONS, ProjectedTable, SnowMix};
use wide::{f32x4, i32x4};

use crate::film::sensor::SensorSample;
use crate::geometry::chord::Exit;
use crate::geometry::lanes::{LANES, LaneMask, RayPacket4, SurfacePoints4, groups, lanes};
use crate::scene::light::{Arrivals, Light, Source};
use crate::scene::material::Material;
use crate::scene::material::diffuse::Diffuse;
use crate::scene::material::pca_snow::{Emission, PathMode, PcaSnowMaterial, Reflection};
use crate::scene::objects::Side;
use crate::scene::queries::{Chords, Lines, SceneQueries, Surfaces};
use crate::scene::{IntegratorKind, Scene};
use crate::spectrum::{SAMPLES, Spectrum};

/// Colours of four samples.
pub(crate) type Colours = [SensorSample; LANES];

/// The lamps of a scene, and what its materials make of their colours.
#[derive(Debug)]
pub(crate) struct DirectLight<'scene> {
    lamps: Vec<Lamp>,
    /// One for each material.
    finishes: Vec<Finish<'scene>>,
}

/// One lamp.
#[derive(Debug)]
struct Lamp {
    source: Source,
    /// The colour of one unit at each wavelength of what is made of its light.
    weights: [[f32; PROJECTIONS]; SAMPLES],
}

/// A material in the light of each lamp.
#[derive(Debug)]
enum Finish<'scene> {
    /// The colours that it reflects.
    Diffuse(Vec<SensorSample>),
    /// Snow.
    Snow(LitSnow<'scene>),
}

/// Snow in the light of each lamp.
#[derive(Debug)]
struct LitSnow<'scene> {
    material: &'scene PcaSnowMaterial,
    curves: &'scene PcaSnow,
    projected: Vec<ProjectedTable>,
    /// The colours that it reflects, if they are no matter of the table.
    constant: Option<Vec<SensorSample>>,
}

/// Snow in the light of one of them.
struct LitBy<'lit> {
    snow: &'lit LitSnow<'lit>,
    lamp: &'lit Lamp,
    projected: &'lit ProjectedTable,
}

/// Rays that hit the same object.
struct Group<'surfaces> {
    object: usize,
    which: LaneMask,
    surfaces: &'surfaces Surfaces,
}

/// Ways of light through snow.
struct Passages {
    /// Those that there are.
    which: LaneMask,
    /// Those that have no entry, as the lamp is inside.
    inside: LaneMask,
    /// Depths of the snow, in cm.
    depth_cm: f32x4,
    /// Angles at which the light meets the snow, in degrees.
    angle_deg: f32x4,
    /// Irradiance there per unit of the lamp's power, if nothing hides it.
    irradiance_per_power: f32x4,
    /// Where that is, and on which object.
    entries: SurfacePoints4,
    objects: i32x4,
}

impl<'scene> DirectLight<'scene> {
    /// The short way for a scene, if it is enough: for lamps without extent, no bounces, and materials that are the same
    /// everywhere.
    pub(crate) fn of(scene: &'scene Scene) -> Option<Self> {
        let settings = &scene.integrator;
        if settings.kind != IntegratorKind::PcaSnow || settings.max_bounces > 0 || !scene.sensor.is_standard_observer()
        {
            return None;
        }
        let lamp = |light: &Light| {
            let weights = scene.sensor.weights_of(&light.single()?.power);
            Some(Lamp { source: Source::of(light)?, weights })
        };
        let lamps: Vec<Lamp> = scene.lights.iter().map(lamp).collect::<Option<_>>()?;
        let finishes = scene.materials.iter().map(|material| Finish::of(material, &lamps)).collect::<Option<_>>()?;
        Some(Self { lamps, finishes })
    }

    /// The colours of the light that arrives along some rays, and which of them hit anything.
    pub(crate) fn colours(&self, probe: &mut SceneQueries, rays: &RayPacket4, which: LaneMask) -> (Colours, LaneMask) {
        let surfaces = probe.camera_hits(rays, which);
        let mut colours = [SensorSample::ZERO; LANES];
        for (object, which) in groups(surfaces.found, surfaces.objects) {
            let group = Group { object, which, surfaces: &surfaces };
            match &self.finishes[probe.objects().list()[object].material] {
                Finish::Diffuse(own) => self.reflect(probe, &group, &mut colours, |lamp, _, _| [own[lamp]; LANES]),
                Finish::Snow(snow) => self.leave(snow, probe, &group, &mut colours),
            }
        }
        (colours, surfaces.found)
    }

    /// Adds L = R E / π of all lamps that shine on some surfaces; `reflected` is R for one of them, in the lanes where it does.
    #[inline]
    fn reflect(
        &self,
        probe: &mut SceneQueries,
        group: &Group,
        colours: &mut Colours,
        reflected: impl Fn(usize, &Arrivals, LaneMask) -> Colours,
    ) {
        let places = &group.surfaces.places;
        for (number, lamp) in self.lamps.iter().enumerate() {
            let arrivals = lamp.source.arrivals(places, group.which);
            let lit = lamp.source.reaches(probe, (places, Side::Outer(group.object)), arrivals.which);
            if lit == 0 {
                continue;
            }
            let reflected = reflected(number, &arrivals, lit);
            for lane in lanes(lit) {
                colours[lane] += reflected[lane] * (arrivals.irradiance_per_power.as_array()[lane] * FRAC_1_PI);
            }
        }
    }

    /// Adds the light that leaves snow.
    fn leave(&self, snow: &LitSnow, probe: &mut SceneQueries, group: &Group, colours: &mut Colours) {
        let straight = snow.straight(probe, group);
        self.reflect(probe, group, colours, |lamp, arrivals, lit| snow.reflected(lamp, &straight, arrivals, lit));
        for (lamp, projected) in self.lamps.iter().zip(&snow.projected) {
            LitBy { snow, lamp, projected }.add_through(probe, group, &straight, colours);
        }
    }
}

impl LitSnow<'_> {
    /// The paths through the snow that do not depend on the light.
    fn straight(&self, probe: &mut SceneQueries, group: &Group) -> Chords {
        let direction = match self.material.path {
            PathMode::View => group.surfaces.direction,
            PathMode::Normal | PathMode::Light | PathMode::Brightest => -group.surfaces.places.normal,
        };
        let lines = Lines { from: group.surfaces.places, direction, end_m: f32x4::splat(f32::INFINITY) };
        probe.chords(group.object, &lines, self.material.exit, group.which)
    }

    /// The colours of a lamp that it reflects, of those lanes that are lit.
    fn reflected(&self, lamp: usize, straight: &Chords, arrivals: &Arrivals, lit: LaneMask) -> Colours {
        if let Some(constant) = &self.constant {
            return [constant[lamp]; LANES];
        }
        let (depth_cm, angle_deg) = (straight.depth_cm(), angle_deg(arrivals, self.curves.last_angle_deg()));
        let mut colours = [SensorSample::ZERO; LANES];
        for lane in lanes(lit) {
            let [depth_cm, angle_deg] = [depth_cm, angle_deg].map(|four| four.as_array()[lane]);
            colours[lane] = SensorSample::from_array(self.projected[lamp].reflectance(depth_cm, angle_deg));
        }
        colours
    }
}

impl LitBy<'_> {
    /// Adds what comes of the lamp through the snow: of two ways the brighter one, and the darker where that is hidden, as the
    /// [long way](crate::scene::material::pca_snow::SnowHit) does.
    fn add_through(&self, probe: &mut SceneQueries, group: &Group, straight: &Chords, colours: &mut Colours) {
        let (along, line) = (self.along(straight), self.on_lines(probe, group));
        let both = along.which & line.which;
        let (mut light_along, mut light_on_line) = ([SensorSample::ZERO; LANES], [SensorSample::ZERO; LANES]);
        let mut prefers_line = line.which & !along.which;
        for lane in lanes(both) {
            (light_along[lane], light_on_line[lane]) = (self.light(&along, lane), self.light(&line, lane));
            prefers_line |= u32::from(light_on_line[lane].y > light_along[lane].y) << lane;
        }
        let side_on_line = if self.snow.material.exit == Exit::Last { Side::Last } else { Side::Inner };
        let along_in = |probe: &mut SceneQueries, which| along.let_in(probe, &self.lamp.source, Side::Inner, which);
        let line_in = |probe: &mut SceneQueries, which| line.let_in(probe, &self.lamp.source, side_on_line, which);
        let lit_along = along_in(probe, along.which & !prefers_line);
        let lit_on_line = line_in(probe, prefers_line);
        let lit_along = lit_along | along_in(probe, both & prefers_line & !lit_on_line);
        let lit_on_line = lit_on_line | line_in(probe, both & !prefers_line & !lit_along);
        for (passages, lit, lights) in [(&along, lit_along, &light_along), (&line, lit_on_line, &light_on_line)] {
            for lane in lanes(lit) {
                colours[lane] += if both >> lane & 1 == 1 { lights[lane] } else { self.light(passages, lane) };
            }
        }
    }

    /// The ways along the paths that do not depend on the light, if the material takes them and their exits face the lamp.
    fn along(&self, straight: &Chords) -> Passages {
        if self.snow.material.path == PathMode::Light {
            return Passages::NONE;
        }
        Passages::through_exits(straight, &self.lamp.source, straight.found, self.snow.curves.last_angle_deg())
    }

    /// The ways on the lines to the lamp, if the material takes them.
    fn on_lines(&self, probe: &mut SceneQueries, group: &Group) -> Passages {
        let (from, source, material) = (group.surfaces.places, &self.lamp.source, self.snow.material);
        if matches!(material.path, PathMode::View | PathMode::Normal) {
            return Passages::NONE;
        }
        let way = source.ways(from.point);
        // A light before the face shines on it; what else of the object stands between is not a way to its inside.
        let behind = !from.normal.dot(way.direction).simd_ge(f32x4::ZERO).to_bitmask();
        let lines = Lines { from, direction: way.direction, end_m: way.distance_m };
        let chords = probe.chords(group.object, &lines, material.exit, group.which & behind);
        let mut passages =
            Passages::through_exits(&chords, source, chords.found & !chords.inside, self.snow.curves.last_angle_deg());
        if chords.inside != 0 {
            passages.add_inside(&source.arrivals(&SurfacePoints4 { normal: way.direction, ..from }, chords.inside));
        }
        passages
    }

    /// L = T E / π of a way.
    #[inline]
    fn light(&self, passages: &Passages, lane: usize) -> SensorSample {
        let [depth_cm, angle_deg] = [passages.depth_cm, passages.angle_deg].map(|four| four.as_array()[lane]);
        let transmittance = if depth_cm <= self.projected.last_thickness_cm() {
            SensorSample::from_array(self.projected.transmittance(depth_cm, angle_deg))
        } else {
            let mut spectrum = Spectrum::ZERO;
            SnowMix::single(self.snow.curves).transmittance(depth_cm, angle_deg, &mut spectrum.0);
            self.lamp.colour_of(&spectrum)
        };
        transmittance * (passages.irradiance_per_power.as_array()[lane] * FRAC_1_PI)
    }
}

impl Passages {
    const NONE: Self = Self {
        which: 0,
        inside: 0,
        depth_cm: f32x4::ZERO,
        angle_deg: f32x4::ZERO,
        irradiance_per_power: f32x4::ZERO,
        entries: SurfacePoints4::NONE,
        objects: i32x4::ZERO,
    };

    /// The ways along some paths whose exits face a lamp.
    #[inline]
    fn through_exits(chords: &Chords, source: &Source, which: LaneMask, last_angle_deg: f32) -> Self {
        let arrivals = source.arrivals(&chords.exits, which);
        Self {
            which: arrivals.which,
            inside: 0,
            depth_cm: chords.depth_cm(),
            angle_deg: angle_deg(&arrivals, last_angle_deg),
            irradiance_per_power: arrivals.irradiance_per_power,
            entries: chords.exits,
            objects: chords.objects,
        }
    }

    /// Adds ways that end at a lamp inside, where light goes straight on.
    fn add_inside(&mut self, arrivals: &Arrivals) {
        for lane in lanes(arrivals.which) {
            self.angle_deg.as_mut_array()[lane] = 0.0;
            self.irradiance_per_power.as_mut_array()[lane] = arrivals.irradiance_per_power.as_array()[lane];
        }
        self.inside |= arrivals.which;
        self.which |= arrivals.which;
    }

    /// Those of some ways where the lamp shines on the place where the light goes in.
    #[inline]
    fn let_in(&self, probe: &mut SceneQueries, source: &Source, side: fn(usize) -> Side, which: LaneMask) -> LaneMask {
        let entering = groups(which & !self.inside, self.objects);
        entering.fold(which & self.inside, |lit, (object, here)| {
            lit | source.reaches(probe, (&self.entries, side(object)), here)
        })
    }
}

/// The angles of incidence in degrees, at most the table's last. They have the bits of one program: a build with fused products
/// rounds them otherwise.
#[inline]
fn angle_deg(arrivals: &Arrivals, last_angle_deg: f32) -> f32x4 {
    let angle = arrivals.cos_incidence.fast_min(f32x4::ONE).acos();
    (angle * f32x4::splat(1.0_f32.to_degrees())).fast_min(f32x4::splat(last_angle_deg))
}

impl Lamp {
    /// The colour of its light after a share of each wavelength is left.
    fn colour_of(&self, shares: &Spectrum) -> SensorSample {
        shares.0.iter().zip(self.weights).map(|(share, weights)| SensorSample::from_array(weights) * *share).sum()
    }
}

impl<'scene> Finish<'scene> {
    fn of(material: &'scene Material, lamps: &[Lamp]) -> Option<Self> {
        match material {
            Material::Diffuse(Diffuse::Even(reflectance)) => {
                Some(Self::Diffuse(lamps.iter().map(|lamp| lamp.colour_of(reflectance)).collect()))
            }
            Material::Diffuse(Diffuse::Painted(_)) => None,
            Material::PcaSnow(snow) if snow.emission == Emission::Relative => None,
            Material::PcaSnow(material) => {
                let curves = material.curves.the_one()?;
                let projected = lamps.iter().map(|lamp| curves.project(&lamp.weights)).collect::<Option<_>>()?;
                let constant = match material.reflection {
                    Reflection::Table => None,
                    Reflection::Constant(share) => {
                        Some(lamps.iter().map(|lamp| lamp.colour_of(&Spectrum::constant(share))).collect())
                    }
                };
                Some(Self::Snow(LitSnow { material, curves, projected, constant }))
            }
        }
    }
}
