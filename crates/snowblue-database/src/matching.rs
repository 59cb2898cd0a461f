//! Snow whose transmitted light has a wanted colour, but for its luminance.
//!
//! Light through snow runs along nearly one curve of chromaticities, from that of the bare light into deep blue: more snow,
//! denser snow and finer grains all move it the same way, since deep in snow ln T goes with h √(σ_a κ (1 − g)). One *free
//! parameter* is therefore enough to meet a colour, and what it meets is met by other snows too, which differ in how much
//! light they pass. Free parameters are fitted one after the other: the next one only when the one before stands at the
//! end of its range.
//!
//! What is made least is ΔE*ab with both lights brought to L* = 50: at a dark target's own luminance any hue would pass for
//! any other. A range is scanned, and the interval around the best value is scanned again, finer, until it is narrow. All
//! light is solved by discrete ordinates, with one tally of grains for all snows.

use rayon::prelude::*;
use snowblue_color::{ColorDifference, Colorimeter, Lab, Xyz, difference::MIDDLE_GREY};
use snowblue_transport::ordinates::{OrdinatesOptions, Peak};
use snowblue_transport::sample::{GrainSize, SnowSample};
use snowblue_transport::slab::{Incidence, Slab};
use snowblue_transport::{Demand, GrainTallies, Population, TallyPlan};

use crate::DatabaseError;
use crate::fidelity::PERCEPTIBLE_DELTA_E;

/// Mean grain sizes that are tried, in µm: from very fine to coarse snow (Fierz et al. 2009: below 0.2 mm and 1–2 mm).
pub const GRAIN_SIZES_UM: (f64, f64) = (100.0, 2000.0);
/// Densities that are tried, in kg/m³: those of a snowpack (Varsa & Baranoski 2024, "Background").
pub const DENSITIES_KG_M3: (f64, f64) = (100.0, 450.0);
/// Thicknesses that are tried, in cm: the paper's.
pub const THICKNESSES_CM: (f64, f64) = (0.0, 100.0);

/// Other snows of the same colour, by their mean grain size in µm or, where that is given, their density in kg/m³.
const OTHER_SIZES_UM: [f64; 4] = [100.0, 200.0, 500.0, 1000.0];
const OTHER_DENSITIES_KG_M3: [f64; 3] = [100.0, 200.0, 400.0];

/// Values of the first scan of a range, and of each finer one.
const COARSE: u32 = 64;
const FINE: u32 = 16;
/// A scan ends when its interval is this narrow, relative to the end of the range.
const NARROW: f64 = 1e-7;
/// A parameter that brings less than this ΔE is left as it was.
const WORTH: f64 = 1e-4;
/// Luminance, with the bare light's Y = 1, below which no light counts: of full sun (10⁵ lx)
/// 10⁻¹² leave a ten-thousandth of starlight (10⁻³ lx), which has no colour to an eye.
const LEAST_LUMINANCE: f64 = 1e-12;

/// What can be fitted to meet a colour.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Parameter {
    /// Thickness, in cm.
    Thickness,
    /// Mean grain size, in µm.
    GrainSize,
    /// Density of the dry snow, in kg/m³.
    Density,
}

/// A free parameter and its range.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Free {
    /// What is free.
    pub parameter: Parameter,
    /// The range, in the parameter's unit.
    pub range: (f64, f64),
}

/// The colour that is wanted, and the eye and the light that see it.
#[derive(Debug, Clone, Copy)]
pub struct Target<'c> {
    /// The colour; its luminance does not count.
    pub color: Xyz,
    /// The white of CIELAB.
    pub white: Xyz,
    /// From transmittance to colour.
    pub colorimeter: &'c Colorimeter,
}

/// The snow that is there before anything is fitted, and what can be.
#[derive(Debug, Clone, PartialEq)]
pub struct Snow {
    /// What is not free stays as it is here.
    pub sample: SnowSample,
    /// Thickness, in cm, unless it is free.
    pub thickness_cm: f64,
    /// The light.
    pub incidence: Incidence,
    /// The free parameters in the order in which they are fitted.
    pub free: Vec<Free>,
}

/// Snow that comes as close as it can.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Match {
    /// The snow.
    pub sample: SnowSample,
    /// Its thickness, in cm.
    pub thickness_cm: f64,
    /// The light that comes through, with the bare light's Y = 1.
    pub light: Xyz,
    /// The difference of this light from the target.
    pub difference: ColorDifference,
}

impl Match {
    /// Whether an eye would see no difference, both lights at L* = 50.
    #[must_use]
    pub fn within_reach(&self) -> bool {
        self.difference.at_middle_grey <= PERCEPTIBLE_DELTA_E
    }

    /// How the target differs from this light, both at L* = 50: in a word, and by Δa* and Δb*.
    #[must_use]
    pub fn direction(&self, target: &Target) -> (&'static str, f64, f64) {
        let lab = |color: Xyz| Lab::from_xyz(color.with_luminance(MIDDLE_GREY), target.white);
        let (wanted, found) = (lab(target.color), lab(self.light));
        (direction(wanted, found), wanted.a - found.a, wanted.b - found.b)
    }
}

/// Hue angles in CIELAB, in degrees, that light through snow has under daylight, with some room: from cyan to blue.
const BLUES_DEG: (f64, f64) = (190.0, 305.0);
/// Hue angles at which another name begins, and the names.
const HUES_DEG: [(f64, &str); 5] =
    [(0.0, "redder"), (60.0, "yellower"), (105.0, "greener"), (BLUES_DEG.1, "more purple"), (350.0, "redder")];

/// What a wanted colour is more than the one that was found: what its hue is called, unless that is blue itself.
fn direction(wanted: Lab, found: Lab) -> &'static str {
    let more_chroma = wanted.chroma() - found.chroma();
    let apart = (wanted.a - found.a).hypot(wanted.b - found.b);
    let mostly_chroma = more_chroma.abs() >= std::f64::consts::FRAC_1_SQRT_2 * apart;
    let hue_deg = wanted.hue_deg();
    if mostly_chroma && more_chroma < 0.0 {
        return "paler";
    }
    if (BLUES_DEG.0..BLUES_DEG.1).contains(&hue_deg) {
        let turned = found.a * wanted.b - found.b * wanted.a;
        return match (mostly_chroma, turned > 0.0) {
            (true, _) => "more saturated",
            (false, true) => "more purple",
            (false, false) => "greener",
        };
    }
    let named = HUES_DEG.iter().rev().find(|(from_deg, _)| hue_deg >= *from_deg);
    named.map_or(HUES_DEG[0].1, |(_, name)| name)
}

/// The snow that comes closest, then others of the same colour as far as they reach, with other grain sizes or else densities.
///
/// Of snows that let the same light through, all those without thickness, the first stands for all; others through which no
/// light comes are left out.
///
/// # Errors
/// [`DatabaseError::DarkTarget`] if the target has no luminance, [`DatabaseError::NoLight`] if nothing comes through
/// the first even in the best case, and what is out of the model's range.
pub fn closest(target: &Target, snow: &Snow, options: &OrdinatesOptions) -> Result<Vec<Match>, DatabaseError> {
    if target.color.y <= 0.0 {
        return Err(DatabaseError::DarkTarget);
    }
    let others = others(snow)?;
    for one in std::iter::once(snow).chain(&others) {
        one.check(target.colorimeter.wavelengths_nm())?;
    }
    options.streams.check()?;
    let search = Search::new(target, snow, options);
    let mut found = vec![search.closest(snow)?];
    for other in &others {
        match search.closest(other) {
            Ok(new) if found.iter().all(|one| one.light != new.light) => found.push(new),
            Ok(_) | Err(DatabaseError::NoLight { .. }) => {}
            Err(error) => return Err(error),
        }
    }
    Ok(found)
}

/// The like of a snow with another value of the second of its free parameters, where there is one.
fn others(snow: &Snow) -> Result<Vec<Snow>, DatabaseError> {
    let Some(second) = snow.free.get(1) else { return Ok(Vec::new()) };
    let values: &[f64] = match second.parameter {
        Parameter::GrainSize => &OTHER_SIZES_UM,
        Parameter::Density => &OTHER_DENSITIES_KG_M3,
        Parameter::Thickness => &[],
    };
    let like = |value: &f64| {
        let mut other = snow.clone();
        other.set(second.parameter, *value)?;
        other.free.remove(1);
        Ok(other)
    };
    values.iter().map(like).collect()
}

impl Snow {
    /// Sets a parameter.
    fn set(&mut self, parameter: Parameter, value: f64) -> Result<(), DatabaseError> {
        match parameter {
            Parameter::Thickness => self.thickness_cm = value,
            Parameter::Density => self.sample.density_kg_m3 = value,
            Parameter::GrainSize => {
                let measure = self.sample.grain_size.measure;
                self.sample.grain_size = GrainSize { measure, ..GrainSize::around(value)? };
            }
        }
        Ok(())
    }

    /// Checks the snow as it is and at both ends of every range.
    fn check(&self, wavelengths_nm: &[f64]) -> Result<(), DatabaseError> {
        let slab = |snow: &Self| Slab {
            sample: snow.sample,
            thicknesses_cm: vec![snow.thickness_cm],
            incidences: vec![snow.incidence],
            wavelengths_nm: wavelengths_nm.to_vec(),
        };
        slab(self).check()?;
        for free in &self.free {
            for end in [free.range.0, free.range.1] {
                let mut at_end = self.clone();
                at_end.set(free.parameter, end)?;
                slab(&at_end).check()?;
            }
        }
        Ok(())
    }
}

/// Grains tallied once for every snow.
struct Search<'t> {
    target: &'t Target<'t>,
    incidence: Incidence,
    tallies: GrainTallies,
    options: OrdinatesOptions,
}

impl<'t> Search<'t> {
    fn new(target: &'t Target<'t>, snow: &Snow, options: &OrdinatesOptions) -> Self {
        let alone = Demand::of_sample(&snow.sample, target.colorimeter.wavelengths_nm());
        // Sizes reach beyond their mean.
        let demand = Demand { largest_um: alone.largest_um.max(1.5 * GRAIN_SIZES_UM.1), ..alone };
        let plan = TallyPlan {
            degree: options.streams.most(&[snow.incidence], Peak::of(&snow.sample)),
            rays: options.tally_rays,
            seed: options.seed,
        };
        let tallies = GrainTallies::new(&Population::of_sample(&snow.sample), &demand, &plan);
        Self { target, incidence: snow.incidence, tallies, options: *options }
    }

    /// Fits one free parameter after the other until one need not go to the end of its range.
    fn closest(&self, snow: &Snow) -> Result<Match, DatabaseError> {
        let mut snow = snow.clone();
        let mut best = self.look(&snow, &[snow.thickness_cm])[0];
        for free in snow.free.clone() {
            let (value, found) = self.scan(&snow, free)?;
            if found.difference.at_middle_grey < best.difference.at_middle_grey - WORTH {
                snow.set(free.parameter, value)?;
                best = found;
            }
            if free.range.0 < value && value < free.range.1 {
                break;
            }
        }
        if best.light.y >= LEAST_LUMINANCE {
            Ok(best)
        } else {
            Err(DatabaseError::NoLight { thickness_cm: best.thickness_cm })
        }
    }

    /// The best value of a free parameter, the others standing.
    fn scan(&self, snow: &Snow, free: Free) -> Result<(f64, Match), DatabaseError> {
        let mut values = coarse_values(free.range);
        loop {
            let found = self.look_at(snow, free.parameter, &values)?;
            let delta = |number: &usize| found[*number].difference.at_middle_grey;
            let best = (0..values.len()).min_by(|a, b| delta(a).total_cmp(&delta(b))).unwrap_or_default();
            let (below, above) = (values[best.saturating_sub(1)], values[(best + 1).min(values.len() - 1)]);
            if above - below <= NARROW * free.range.1 {
                return Ok((values[best], found[best]));
            }
            values = (0..=FINE).map(|i| below + (above - below) * f64::from(i) / f64::from(FINE)).collect();
            // The ends of the range are kept as they are, and told from values inside.
            values[FINE as usize] = above;
        }
    }

    fn look_at(&self, snow: &Snow, parameter: Parameter, values: &[f64]) -> Result<Vec<Match>, DatabaseError> {
        if parameter == Parameter::Thickness {
            return Ok(self.look(snow, values));
        }
        let mut found = Vec::with_capacity(values.len());
        for value in values {
            let mut other = snow.clone();
            other.set(parameter, *value)?;
            found.extend(self.look(&other, &[other.thickness_cm]));
        }
        Ok(found)
    }

    /// The light through several thicknesses of a snow.
    fn look(&self, snow: &Snow, thicknesses_cm: &[f64]) -> Vec<Match> {
        let (streams, peak) = (self.options.streams, Peak::of(&snow.sample));
        let at = |wavelength_nm: &f64| -> Vec<f64> {
            let medium = self.tallies.medium(&snow.sample, *wavelength_nm, None);
            let fluxes = medium.fluxes(thicknesses_cm, &[self.incidence], streams, peak);
            fluxes.into_iter().map(|fluxes| fluxes.transmittance).collect()
        };
        let by_wavelength: Vec<Vec<f64>> = self.target.colorimeter.wavelengths_nm().par_iter().map(at).collect();
        let one = |(number, thickness_cm): (usize, &f64)| {
            let spectrum: Vec<f64> = by_wavelength.iter().map(|values| values[number]).collect();
            let light = self.target.colorimeter.xyz(&spectrum);
            let difference = if light.y >= LEAST_LUMINANCE {
                ColorDifference::between(light, self.target.color, self.target.white)
            } else {
                ColorDifference::INFINITE
            };
            Match { sample: snow.sample, thickness_cm: *thickness_cm, light, difference }
        };
        thicknesses_cm.iter().enumerate().map(one).collect()
    }
}

/// Values over a range in equal steps of the logarithm, down to a thousandth of its end, and its start.
fn coarse_values((least, most): (f64, f64)) -> Vec<f64> {
    if least >= most {
        return vec![least];
    }
    let first = least.max(1e-3 * most);
    let step = |i: u32| first * (most / first).powf(f64::from(i) / f64::from(COARSE));
    let mut values: Vec<f64> = (0..COARSE).map(step).collect();
    values.push(most);
    if least < first {
        values.insert(0, least);
    } else {
        values[0] = least;
    }
    values
}
