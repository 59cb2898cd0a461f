//! Snow whose transmitted light has a wanted colour, but for its luminance.
//!
//! Light through snow runs along nearly one curve of chromaticities, from that of the bare light into deep blue: more snow,
//! denser snow and finer grains all move it the same way, since deep in snow ln T goes with h √(σ_a κ (1 − g)). One *dial*
//! is therefore enough to meet a colour, and what it meets is met by a family of snows, which differ in how much light
//! they pass. Dials are turned one after the other: the next one only when the one before stands at the end of its range.
//!
//! A dial's range is scanned, and the interval around the best place is scanned again, finer, until it is narrow. All
//! light is solved by discrete ordinates, with one tally of grains for the whole family.

use rayon::prelude::*;
use snowblue_color::{Colorimeter, Difference, Lab, Xyz, difference::exposed};
use snowblue_transport::ordinates::{OrdinatesOptions, Peak};
use snowblue_transport::sample::{GrainSize, SnowSample};
use snowblue_transport::slab::{Incidence, Slab};
use snowblue_transport::{Demand, GrainTallies, Population, TallyPlan};

use crate::DatabaseError;
use crate::fidelity::PERCEPTIBLE_DELTA_E;

/// Mean grain sizes that are tried, in µm: from fine to very coarse snow (Fierz et al. 2009, table 1.3).
pub const GRAIN_SIZES_UM: (f64, f64) = (100.0, 2000.0);
/// Densities that are tried, in kg/m³: those of a snowpack (Varsa & Baranoski 2024, "Background").
pub const DENSITIES_KG_M3: (f64, f64) = (100.0, 450.0);
/// Thicknesses that are tried, in cm: the paper's.
pub const THICKNESSES_CM: (f64, f64) = (0.0, 100.0);

/// Other snows of a family, by their mean grain size in µm or, where that is given, their density in kg/m³.
const FAMILY_SIZES_UM: [f64; 4] = [100.0, 200.0, 500.0, 1000.0];
const FAMILY_DENSITIES_KG_M3: [f64; 3] = [100.0, 200.0, 400.0];

/// Places of the first scan of a dial, and of each finer one.
const COARSE: u32 = 64;
const FINE: u32 = 16;
/// A scan ends when its interval is this narrow, relative to the end of the range.
const NARROW: f64 = 1e-7;
/// A dial that brings less than this ΔE is left alone.
const WORTH: f64 = 1e-4;

/// What can be turned to meet a colour.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Dial {
    /// Thickness, in cm.
    Thickness,
    /// Mean grain size, in µm.
    GrainSize,
    /// Density of the dry snow, in kg/m³.
    Density,
}

/// A dial and the range that it has.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Turn {
    /// What is turned.
    pub dial: Dial,
    /// The range, in the dial's unit.
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

/// The snow that is there before anything is turned, and what can be.
#[derive(Debug, Clone, PartialEq)]
pub struct Snow {
    /// What is not turned stays as it is here.
    pub sample: SnowSample,
    /// Thickness, in cm, unless it is turned.
    pub thickness_cm: f64,
    /// The light.
    pub incidence: Incidence,
    /// The dials in the order in which they are turned.
    pub turns: Vec<Turn>,
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
    pub difference: Difference,
}

impl Match {
    /// Whether an eye would see no difference at the target's luminance.
    #[must_use]
    pub fn within_reach(&self) -> bool {
        self.difference.at_equal_luminance <= PERCEPTIBLE_DELTA_E
    }

    /// How the target differs from this light at its luminance: in a word, and by Δa* and Δb*.
    #[must_use]
    pub fn direction(&self, target: &Target) -> (&'static str, f64, f64) {
        let lab = |color| Lab::from_xyz(color, target.white);
        let (wanted, found) = (lab(target.color), lab(exposed(self.light, target.color.y)));
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
    let more_chroma = wanted.a.hypot(wanted.b) - found.a.hypot(found.b);
    let apart = (wanted.a - found.a).hypot(wanted.b - found.b);
    let mostly_chroma = more_chroma.abs() >= std::f64::consts::FRAC_1_SQRT_2 * apart;
    let hue_deg = wanted.b.atan2(wanted.a).to_degrees().rem_euclid(360.0);
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

/// The snow that comes closest, then others of its family, with other grain sizes or else densities.
///
/// # Errors
/// [`DatabaseError::DarkTarget`] if the target has no luminance, [`DatabaseError::NoLight`] if nothing comes through even
/// in the best case, and what is out of the model's range.
pub fn family(target: &Target, snow: &Snow, options: &OrdinatesOptions) -> Result<Vec<Match>, DatabaseError> {
    if target.color.y <= 0.0 {
        return Err(DatabaseError::DarkTarget);
    }
    let members = members(snow)?;
    for member in &members {
        member.check(target.colorimeter.wavelengths_nm())?;
    }
    options.streams.check()?;
    let search = Search::new(target, snow, options);
    members.iter().map(|member| search.closest(member)).collect()
}

/// The snow itself, and its like with another value on the second of its dials, where there is one.
fn members(snow: &Snow) -> Result<Vec<Snow>, DatabaseError> {
    let mut members = vec![snow.clone()];
    let Some(second) = snow.turns.get(1) else { return Ok(members) };
    let values: &[f64] = match second.dial {
        Dial::GrainSize => &FAMILY_SIZES_UM,
        Dial::Density => &FAMILY_DENSITIES_KG_M3,
        Dial::Thickness => &[],
    };
    for value in values {
        let mut other = snow.clone();
        other.set(second.dial, *value)?;
        other.turns.remove(1);
        members.push(other);
    }
    Ok(members)
}

impl Snow {
    /// Sets a dial.
    fn set(&mut self, dial: Dial, value: f64) -> Result<(), DatabaseError> {
        match dial {
            Dial::Thickness => self.thickness_cm = value,
            Dial::Density => self.sample.density_kg_m3 = value,
            Dial::GrainSize => {
                let measure = self.sample.grain_size.measure;
                self.sample.grain_size = GrainSize { measure, ..GrainSize::around(value)? };
            }
        }
        Ok(())
    }

    /// Checks the snow as it is and at both ends of every dial.
    fn check(&self, wavelengths_nm: &[f64]) -> Result<(), DatabaseError> {
        let slab = |snow: &Self| Slab {
            sample: snow.sample,
            thicknesses_cm: vec![snow.thickness_cm],
            incidences: vec![snow.incidence],
            wavelengths_nm: wavelengths_nm.to_vec(),
        };
        slab(self).check()?;
        for turn in &self.turns {
            for end in [turn.range.0, turn.range.1] {
                let mut at_end = self.clone();
                at_end.set(turn.dial, end)?;
                slab(&at_end).check()?;
            }
        }
        Ok(())
    }
}

/// Grains tallied once for every snow of a family.
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

    /// Turns one dial after the other until one need not go to its end.
    fn closest(&self, snow: &Snow) -> Result<Match, DatabaseError> {
        let mut snow = snow.clone();
        let mut best = self.look(&snow, &[snow.thickness_cm])[0];
        for turn in snow.turns.clone() {
            let (place, found) = self.scan(&snow, turn)?;
            if found.difference.at_equal_luminance < best.difference.at_equal_luminance - WORTH {
                snow.set(turn.dial, place)?;
                best = found;
            }
            if turn.range.0 < place && place < turn.range.1 {
                break;
            }
        }
        if best.light.y > 0.0 { Ok(best) } else { Err(DatabaseError::NoLight { thickness_cm: best.thickness_cm }) }
    }

    /// The best place of a dial, the others standing.
    fn scan(&self, snow: &Snow, turn: Turn) -> Result<(f64, Match), DatabaseError> {
        let mut places = coarse_places(turn.range);
        loop {
            let found = self.look_at(snow, turn.dial, &places)?;
            let delta = |number: &usize| found[*number].difference.at_equal_luminance;
            let best = (0..places.len()).min_by(|a, b| delta(a).total_cmp(&delta(b))).unwrap_or_default();
            let (below, above) = (places[best.saturating_sub(1)], places[(best + 1).min(places.len() - 1)]);
            if above - below <= NARROW * turn.range.1 {
                return Ok((places[best], found[best]));
            }
            places = (0..=FINE).map(|i| below + (above - below) * f64::from(i) / f64::from(FINE)).collect();
            // The ends of the range are kept as they are, and told from places inside.
            places[FINE as usize] = above;
        }
    }

    fn look_at(&self, snow: &Snow, dial: Dial, places: &[f64]) -> Result<Vec<Match>, DatabaseError> {
        if dial == Dial::Thickness {
            return Ok(self.look(snow, places));
        }
        let mut found = Vec::with_capacity(places.len());
        for place in places {
            let mut turned = snow.clone();
            turned.set(dial, *place)?;
            found.extend(self.look(&turned, &[turned.thickness_cm]));
        }
        Ok(found)
    }

    /// The light through several thicknesses of a snow.
    fn look(&self, snow: &Snow, thicknesses_cm: &[f64]) -> Vec<Match> {
        let how = (self.options.streams, Peak::of(&snow.sample));
        let at = |wavelength_nm: &f64| -> Vec<f64> {
            let medium = self.tallies.medium(&snow.sample, *wavelength_nm, None);
            let fluxes = medium.fluxes(thicknesses_cm, &[self.incidence], how);
            fluxes.into_iter().map(|fluxes| fluxes.transmittance).collect()
        };
        let by_wavelength: Vec<Vec<f64>> = self.target.colorimeter.wavelengths_nm().par_iter().map(at).collect();
        let one = |(number, thickness_cm): (usize, &f64)| {
            let spectrum: Vec<f64> = by_wavelength.iter().map(|values| values[number]).collect();
            let light = self.target.colorimeter.xyz(&spectrum);
            let difference = if light.y > 0.0 {
                Difference::between(light, self.target.color, self.target.white)
            } else {
                Difference::INFINITE
            };
            Match { sample: snow.sample, thickness_cm: *thickness_cm, light, difference }
        };
        thicknesses_cm.iter().enumerate().map(one).collect()
    }
}

/// Places over a range in equal steps of the logarithm, down to a thousandth of its end, and its start.
fn coarse_places((least, most): (f64, f64)) -> Vec<f64> {
    if least >= most {
        return vec![least];
    }
    let first = least.max(1e-3 * most);
    let step = |i: u32| first * (most / first).powf(f64::from(i) / f64::from(COARSE));
    let mut places: Vec<f64> = (0..COARSE).map(step).collect();
    places.push(most);
    if least < first {
        places.insert(0, least);
    } else {
        places[0] = least;
    }
    places
}
