//! Layers of clear ice: closed forms, energy, reciprocity, and random walks.

use snowblue_transport::illumination::{Illumination, light_in_layers};
use snowblue_transport::monte_carlo::{self, MonteCarloOptions};
use snowblue_transport::optics::{IceTable, fresnel};
use snowblue_transport::ordinates::{OrdinatesOptions, Streams, solve_stack_without_errors};
use snowblue_transport::quadrature::Quadrature;
use snowblue_transport::sample::{GrainSize, SnowSample};
use snowblue_transport::slab::Incidence;
use snowblue_transport::stack::{Layer, Stack, StackRadiometry};

const TABLE: IceTable = IceTable::WarrenBrandt2008;
const OPTIONS: OrdinatesOptions = OrdinatesOptions { streams: Streams::Exactly(16), tally_rays: 1 << 12, seed: 1 };
const LIGHTS: [Incidence; 4] = [
    Incidence::Beam { angle_deg: 0.0 },
    Incidence::Beam { angle_deg: 60.0 },
    Incidence::Beam { angle_deg: 89.0 },
    Incidence::Diffuse,
];

fn ice(thickness_cm: f64) -> Layer {
    Layer::ice(TABLE, thickness_cm)
}

fn snow(area_m2_kg: f64, density_kg_m3: f64, thickness_cm: f64) -> Layer {
    let grain_size = GrainSize::from_specific_surface_area(area_m2_kg, -5.0).unwrap();
    Layer::snow(SnowSample { grain_size, density_kg_m3, ..SnowSample::default() }, thickness_cm)
}

/// Ice on top, within, at the bottom, at several places, and alone.
fn packs() -> Vec<(&'static str, Vec<Layer>)> {
    let (fresh, old) = (snow(45.0, 120.0, 2.0), snow(9.0, 400.0, 6.0));
    vec![
        ("alone", vec![ice(3.0)]),
        ("top", vec![ice(0.5), fresh, old]),
        ("middle", vec![fresh, ice(1.0), old]),
        ("bottom", vec![fresh, old, ice(2.0)]),
        ("several", vec![ice(0.2), fresh, ice(0.5), ice(0.3), old, ice(4.0)]),
    ]
}

fn stack(layers: Vec<Layer>, ground_albedo: f64, wavelengths_nm: &[f64]) -> Stack {
    Stack {
        layers,
        ground_albedo: f64::into(ground_albedo),
        depths_cm: vec![],
        incidences: LIGHTS.to_vec(),
        wavelengths_nm: wavelengths_nm.to_vec(),
    }
}

fn solve(stack: &Stack) -> Vec<StackRadiometry> {
    solve_stack_without_errors(stack, &OPTIONS).unwrap()
}

/// Reflectance and transmittance of a slab by adding up internal reflections of each polarisation, one by one.
fn slab(cosine: f64, thickness_cm: f64, nm: f64) -> [f64; 2] {
    let (n, gamma) = (TABLE.index(nm), TABLE.absorption_per_m(nm));
    let refracted = fresnel(cosine, n).cos_refraction;
    let passed = (-gamma * 0.01 * thickness_cm / refracted).exp();
    let s = ((cosine - n * refracted) / (cosine + n * refracted)).powi(2);
    let p = 2.0 * fresnel(cosine, n).reflectance - s;
    let mut sums = [0.0, 0.0];
    for face in [s, p] {
        sums[0] += 0.5 * face;
        let mut inside = 0.5 * (1.0 - face);
        // Twice as many crossings as are needed at grazing angles.
        for crossing in 0..20_000 {
            inside *= passed;
            sums[(crossing + 1) % 2] += inside * (1.0 - face);
            inside *= face;
        }
    }
    sums
}

#[test]
fn ice_alone_has_its_closed_form() {
    for nm in [310.0, 500.0, 1030.0, 1500.0] {
        let solved = solve(&stack(vec![ice(3.0)], 0.0, &[nm]));
        for (answer, cosine) in solved.iter().zip([1.0, 0.5, 89.0_f64.to_radians().cos()]) {
            let [reflected, transmitted] = slab(cosine, 3.0, nm);
            let whole = &answer.whole;
            assert!((whole.fluxes.reflectance.value - reflected).abs() < 1e-12, "{nm} {cosine}: {whole:?} {reflected}");
            assert!(
                (whole.fluxes.transmittance.value - transmitted).abs() < 1e-12,
                "{nm} {cosine}: {whole:?} {transmitted}"
            );
            assert!((answer.direct - transmitted).abs() < 1e-12);
        }
        // Lambertian light by quadrature with 64 nodes, against 8 ordinates.
        let rule = Quadrature::half_range(64);
        let mean = |i: usize| -> f64 {
            rule.cosines.iter().zip(&rule.weights).map(|(mu, weight)| 2.0 * mu * weight * slab(*mu, 3.0, nm)[i]).sum()
        };
        let diffuse = &solved[3];
        assert!((diffuse.whole.fluxes.reflectance.value - mean(0)).abs() < 1e-5, "{nm}: {diffuse:?} {}", mean(0));
        assert!((diffuse.whole.fluxes.transmittance.value - mean(1)).abs() < 1e-5, "{nm}: {diffuse:?} {}", mean(1));
        assert!((diffuse.direct / mean(1) - 1.0).abs() < 1e-9, "{nm}: {diffuse:?} {}", mean(1));
    }
}

/// The net flux is what is not reflected, at the ground what the ground absorbs, at each face the difference of the
/// fluxes down and up, and falls with depth: all of these are computed by separate emissions.
#[test]
fn energy_is_conserved() {
    for (name, layers) in packs() {
        for albedo in [0.0, 0.6, 1.0] {
            for nm in [310.0, 550.0, 1030.0, 1490.0] {
                let mut depths_cm = vec![0.0];
                for layer in &layers {
                    depths_cm.push(depths_cm[depths_cm.len() - 1] + layer.thickness_cm);
                }
                let stack = Stack { depths_cm, ..stack(layers.clone(), albedo, &[nm]) };
                for answer in solve(&stack) {
                    let what = format!("{name} {albedo} {nm} {}", answer.whole.incidence);
                    let (top, ground) = (&answer.profile[0], &answer.profile[layers.len()]);
                    let reflected = answer.whole.fluxes.reflectance.value;
                    assert!((top.down.value - 1.0).abs() < 1e-12 && (top.up.value - reflected).abs() < 1e-12, "{what}");
                    assert!((top.net.value - (1.0 - reflected)).abs() < 1e-12, "{what}: {answer:?}");
                    let arriving = answer.whole.fluxes.transmittance.value;
                    assert!((ground.down.value - arriving).abs() < 1e-12 * arriving, "{what}: {answer:?}");
                    assert!((ground.net.value - (1.0 - albedo) * arriving).abs() < 1e-11 * arriving, "{what}");
                    for face in answer.profile.windows(2) {
                        assert!(face[0].net.value >= face[1].net.value - 1e-12, "{what}");
                    }
                    for at in &answer.profile {
                        let difference = at.down.value - at.up.value - at.net.value;
                        assert!(difference.abs() < 1e-12 * (1.0 + at.down.value), "{what}: {at:?}");
                    }
                }
            }
        }
    }
}

/// Within ice the net flux falls by the fluence rate times the absorption coefficient, by Simpson's rule.
#[test]
fn absorbed_light_is_what_the_net_flux_loses() {
    for (name, layers) in packs() {
        let mut top_cm = 0.0;
        for (number, layer) in layers.iter().enumerate() {
            // Within the faces, where fluxes jump.
            let steps = 400;
            let inset_cm = 1e-9;
            let step_cm = (layer.thickness_cm - 2.0 * inset_cm) / f64::from(steps);
            let depths_cm = (0..=steps).map(|step| top_cm + inset_cm + f64::from(step) * step_cm).collect();
            top_cm += layer.thickness_cm;
            if !layer.is_ice() {
                continue;
            }
            let stack = Stack { depths_cm, ..stack(layers.clone(), 0.3, &[550.0, 1030.0]) };
            for answer in solve(&stack) {
                let sum: f64 = answer
                    .profile
                    .iter()
                    .enumerate()
                    .map(|(step, at)| {
                        let weight = if step == 0 || step == 400 {
                            1.0
                        } else if step % 2 == 1 {
                            4.0
                        } else {
                            2.0
                        };
                        weight * at.absorbed_per_m.value
                    })
                    .sum();
                let absorbed = sum * 0.01 * step_cm / 3.0;
                let lost = answer.profile[0].net.value - answer.profile[400].net.value;
                let incidence = answer.whole.incidence;
                assert!(
                    (absorbed - lost).abs() < 1e-9 * absorbed + 1e-14,
                    "{name} {number} {incidence}: {absorbed:e} {lost:e}"
                );
                // Down and up, whose difference is the net flux.
                for at in &answer.profile {
                    assert!((at.down.value - at.up.value - at.net.value).abs() < 1e-13, "{at:?}");
                    assert!(at.down.value > 0.0 && at.up.value > 0.0 && at.fluence.value > at.down.value + at.up.value);
                }
            }
        }
    }
}

/// Under Lambertian light the transmittance is the same from both sides.
#[test]
fn transmittance_is_reciprocal() {
    for (name, layers) in packs() {
        let reversed: Vec<Layer> = layers.iter().rev().copied().collect();
        for nm in [550.0, 1300.0] {
            let [down, up] = [layers.clone(), reversed.clone()].map(|layers| solve(&stack(layers, 0.0, &[nm])));
            let ratio = down[3].whole.fluxes.transmittance.value / up[3].whole.fluxes.transmittance.value;
            assert!((ratio - 1.0).abs() < 1e-11, "{name} {nm}: {ratio}");
        }
    }
}

/// Two layers of ice without snow between are one slab; snow above and below is as before when it is cut.
#[test]
fn cuts_change_nothing() {
    let (fresh, old) = (snow(45.0, 120.0, 2.0), snow(9.0, 400.0, 6.0));
    let half = Layer { thickness_cm: 1.0, ..fresh };
    let depths_cm = vec![0.0, 0.7, 2.3, 2.5, 3.0, 3.2, 8.0, 9.0];
    let whole = Stack { depths_cm, ..stack(vec![fresh, ice(1.0), old], 0.4, &[450.0, 1100.0]) };
    let cut = Stack { layers: vec![half, half, ice(0.5), ice(0.2), ice(0.3), old], ..whole.clone() };
    for (whole, cut) in solve(&whole).iter().zip(&solve(&cut)) {
        let (r, t) = (whole.whole.fluxes.reflectance.value, whole.whole.fluxes.transmittance.value);
        assert!(
            (cut.whole.fluxes.reflectance.value - r).abs() < 1e-12
                && (cut.whole.fluxes.transmittance.value / t - 1.0).abs() < 1e-11
        );
        assert!((cut.direct - whole.direct).abs() <= 1e-10 * whole.direct, "{} {}", whole.direct, cut.direct);
        for (a, b) in whole.profile.iter().zip(&cut.profile) {
            for (a, b) in [
                (a.down, b.down),
                (a.up, b.up),
                (a.net, b.net),
                (a.fluence, b.fluence),
                (a.absorbed_per_m, b.absorbed_per_m),
            ] {
                assert!(
                    (a.value - b.value).abs() < 1e-11 * (a.value.abs() + whole.profile[0].down.value * 1e-2),
                    "{a:?} {b:?}"
                );
            }
        }
    }
}

/// Random walks, which know neither ordinates nor the closed form of a slab. They find differences of 2 % in
/// probabilities of a half: 4 σ of √(1/4 /8000), of which the noise of the tally is a small part in such thin snow.
#[test]
fn random_walks_agree() {
    let options = MonteCarloOptions { rays: 8_000, seed: 3, ..MonteCarloOptions::default() };
    let exact = OrdinatesOptions { streams: Streams::Exactly(32), tally_rays: 1 << 16, seed: 1 };
    for (name, layers) in packs() {
        for albedo in [0.0, 0.7] {
            let thin = |layer: &Layer| Layer {
                thickness_cm: if layer.is_ice() { layer.thickness_cm } else { 0.15 * layer.thickness_cm },
                ..*layer
            };
            let layers = layers.iter().map(thin).collect();
            let mut stack = stack(layers, albedo, &[1300.0]);
            stack.incidences = vec![Incidence::Beam { angle_deg: 70.0 }, Incidence::Diffuse];
            let walked = monte_carlo::solve_stack(&stack, &options, &|_| ()).unwrap();
            let solved = solve_stack_without_errors(&stack, &exact).unwrap();
            for (walked, solved) in walked.iter().zip(&solved) {
                for (walked, solved) in [
                    (walked.fluxes.reflectance, solved.whole.fluxes.reflectance),
                    (walked.fluxes.transmittance, solved.whole.fluxes.transmittance),
                    (walked.fluxes.absorptance, solved.whole.fluxes.absorptance),
                ] {
                    let sigmas = (walked.value - solved.value) / walked.standard_error;
                    // Of 60 comparisons one is beyond with a probability of 0.4 %.
                    assert!(sigmas.abs() < 4.0, "{name} {albedo}: {walked:?} {solved:?} {sigmas}");
                }
            }
        }
    }
}

/// Light under a sun and a sky: what the layers and the ground absorb is the net flux at the top.
#[test]
fn layers_absorb_what_enters() {
    for (name, layers) in packs() {
        let nm = [400.0, 700.0, 1000.0];
        let stack = Stack { depths_cm: vec![0.0], ..stack(layers, 0.2, &nm) };
        let sun = Illumination { sun_angle_deg: Some(65.0), direct: vec![1.0; 3], diffuse: vec![0.5; 3] };
        let light = &light_in_layers(&stack, &[sun], &OPTIONS).unwrap()[0];
        let bottom = Stack { depths_cm: vec![stack.thickness_cm()], ..stack.clone() };
        let sun = Illumination { sun_angle_deg: Some(65.0), direct: vec![1.0; 3], diffuse: vec![0.5; 3] };
        let ground = &light_in_layers(&bottom, &[sun], &OPTIONS).unwrap()[0];
        for k in 0..3 {
            let absorbed: f64 = light.absorbed.iter().skip(k).step_by(3).sum();
            let entering = light.levels[k].net - ground.levels[k].net;
            assert!((absorbed - entering).abs() < 1e-12, "{name} {k}: {absorbed} {entering}");
            assert!(light.absorbed.iter().all(|absorbed| *absorbed > 0.0), "{name}: {light:?}");
        }
    }
}
