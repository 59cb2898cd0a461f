//! Layers of different snow on a Lambertian ground by Monte Carlo, each wavelength separately: the check of the layered
//! ordinates.
//!
//! Free flights are drawn in optical depth across all layers; the layer at their end provides the grain. The ground
//! reflects a ray with the probability of its albedo. A ray counts in the transmittance each time that it arrives at
//! the ground.
//!
//! In a slab of clear ice a ray has one of both polarisations, with equal probability, and is reflected at each face
//! with the probability that Fresnel's equations give.

use super::rays::{MonteCarloOptions, RayProgress, check_rays, cos_incidence, sum_over_rays};
use super::walk::{Absorption, Paths, Scatterers, scattered_cosine};
use crate::TransportError;
use crate::medium::{Constituents, hit_size_m};
use crate::optics::polarised;
use crate::parameters::THICKNESS;
use crate::rng::Stream;
use crate::slab::Radiometry;
use crate::stack::{LayerKind, Stack};

/// A stack at one wavelength.
#[derive(Default)]
struct OpticalStack {
    /// Layers of snow.
    layers: Vec<OpticalLayer>,
    /// Slabs of ice between them.
    slabs: Vec<IceSlab>,
    /// Optical depth of the ground below the top of the stack.
    ground: f64,
}

/// A slab of ice at one wavelength.
struct IceSlab {
    /// Optical depth of the snow above it.
    place: f64,
    index: f64,
    /// Optical depth of absorption, along the normal.
    absorption: f64,
}

/// A layer of snow at one wavelength.
struct OpticalLayer {
    scatterers: Scatterers,
    absorption: Absorption,
    /// Optical depths of its top and bottom below the top of the stack.
    top: f64,
    bottom: f64,
    /// Optical depth of absorption in the pores above it, along the vertical.
    pores_above: f64,
}

/// Reflectance, flux that arrives at the ground, and absorptance of the snow, for each incidence, then each wavelength.
///
/// `progress` is called with the number of rays traced.
///
/// # Errors
/// If a parameter is out of range, and for a half-space.
pub fn solve_stack(
    stack: &Stack,
    options: &MonteCarloOptions,
    progress: &(dyn Fn(RayProgress) + Sync),
) -> Result<Vec<Radiometry>, TransportError> {
    stack.check()?;
    stack.layers.iter().try_for_each(|layer| THICKNESS.range.check(layer.thickness_cm))?;
    check_rays(options.rays)?;
    let mut answer = Vec::new();
    let total = (stack.incidences.len() * stack.wavelengths_nm.len()) as u64 * options.rays;
    for &incidence in &stack.incidences {
        for &wavelength_nm in &stack.wavelengths_nm {
            let optical = OpticalStack::new(stack, wavelength_nm);
            let ground_albedo = stack.ground_albedo.at(wavelength_nm);
            // The inverted seed makes the streams independent of the streams of slabs.
            let seed = Stream::key(!options.seed, answer.len() as u64);
            let sums = sum_over_rays(options.rays, |ray| {
                let mut stream = Stream::new(seed, ray);
                let cosine = cos_incidence(incidence, &mut stream);
                let [reflected, arrived] = trace_ray(&optical, ground_albedo, cosine, &mut stream);
                [reflected, arrived, 1.0 - reflected - (1.0 - ground_albedo) * arrived]
            });
            answer.push(Radiometry {
                thickness_cm: stack.thickness_cm(),
                incidence,
                wavelength_nm,
                fluxes: [0, 1, 2].map(|quantity| sums.estimate(quantity, options.rays)).into(),
            });
            progress(RayProgress { traced: answer.len() as u64 * options.rays, total });
        }
    }
    Ok(answer)
}

impl OpticalStack {
    fn new(stack: &Stack, wavelength_nm: f64) -> Self {
        let (mut optical, mut pores_above) = (Self::default(), 0.0);
        for (number, layer) in stack.layers.iter().enumerate() {
            let thickness_m = 0.01 * layer.thickness_cm;
            let top = optical.ground;
            match &layer.kind {
                LayerKind::Snow(sample) => {
                    let constituents = Constituents::new(sample, wavelength_nm);
                    let scatterers = Scatterers::new(sample, &constituents);
                    let absorption = Absorption::new(&constituents, &scatterers);
                    let bottom = top + scatterers.extinction_per_m * thickness_m;
                    optical.ground = bottom;
                    optical.layers.push(OpticalLayer { scatterers, absorption, top, bottom, pores_above });
                    pores_above += constituents.pore_absorption_per_m * thickness_m;
                }
                LayerKind::Ice(table) => {
                    let ice = table;
                    let absorption = ice.absorption_per_m(wavelength_nm) * thickness_m;
                    // Neighbouring layers of ice are one slab.
                    let is_further = number > 0 && stack.layers[number - 1].is_ice();
                    match optical.slabs.last_mut().filter(|_| is_further) {
                        Some(slab) => slab.absorption += absorption,
                        None => optical.slabs.push(IceSlab { place: top, index: ice.index(wavelength_nm), absorption }),
                    }
                }
            }
        }
        optical
    }

    /// The layer of snow at an optical depth, or the last one.
    fn layer_at(&self, depth: f64) -> &OpticalLayer {
        let Self { layers, .. } = self;
        &layers[layers.partition_point(|layer| layer.bottom <= depth).min(layers.len() - 1)]
    }

    /// Optical depth of absorption in the pores down to an optical depth, along the vertical.
    fn pore_absorption(&self, depth: f64) -> f64 {
        if self.layers.is_empty() {
            return 0.0;
        }
        let layer = self.layer_at(depth);
        layer.pores_above + layer.absorption.free * (depth - layer.top)
    }
}

impl IceSlab {
    /// Whether a ray that arrives with the cosine of an angle passes the slab; adds the absorption on its way.
    fn is_passed(&self, cosine: f64, absorbed: &mut f64, stream: &mut Stream) -> bool {
        let (cos_refraction, [s, p]) = polarised(cosine, self.index);
        let reflectance = if stream.uniform() < 0.5 { s } else { p };
        if stream.uniform() < reflectance {
            return false;
        }
        let mut passed = false;
        loop {
            *absorbed += self.absorption / cos_refraction;
            passed = !passed;
            if stream.uniform() >= reflectance {
                return passed;
            }
        }
    }
}

/// Traces a ray: the weight that leaves the top, and the weight that arrives at the ground.
fn trace_ray(stack: &OpticalStack, ground_albedo: f64, cos_incidence: f64, stream: &mut Stream) -> [f64; 2] {
    let (mut depth, mut cosine) = (0.0, cos_incidence);
    let (mut absorbed, mut arrived) = (0.0_f64, 0.0);
    // The number of slabs of ice above the ray.
    let mut slabs_above = 0;
    loop {
        let (above, below) = (&stack.slabs[..slabs_above], stack.slabs.get(slabs_above));
        let (top, bottom) =
            (above.last().map_or(0.0, |slab| slab.place), below.map_or(stack.ground, |slab| slab.place));
        let beyond = depth - stream.uniform().ln() * cosine;
        let next = beyond.clamp(top, bottom);
        absorbed += ((stack.pore_absorption(next) - stack.pore_absorption(depth)) / cosine).abs();
        depth = next;
        // Without snow a downward ray reaches what is below it, not the top.
        if cosine < 0.0 && beyond <= top {
            match above.last() {
                None => return [(-absorbed).exp(), arrived],
                Some(slab) if slab.is_passed(-cosine, &mut absorbed, stream) => slabs_above -= 1,
                Some(_) => cosine = -cosine,
            }
            continue;
        }
        if cosine > 0.0 && beyond >= bottom {
            match below {
                Some(slab) if slab.is_passed(cosine, &mut absorbed, stream) => slabs_above += 1,
                Some(_) => cosine = -cosine,
                None => {
                    arrived += (-absorbed).exp();
                    if stream.uniform() >= ground_albedo {
                        return [0.0, arrived];
                    }
                    cosine = -stream.uniform().sqrt();
                }
            }
            continue;
        }
        let layer = stack.layer_at(depth);
        let collision = layer.scatterers.collide(stream);
        let mut paths = Paths::default();
        collision.add_ice_path(hit_size_m(&layer.scatterers.size, stream), &mut paths);
        absorbed += layer.absorption.in_ice(paths.ice_m);
        cosine = scattered_cosine(cosine, collision.cos_scattering, stream);
    }
}
