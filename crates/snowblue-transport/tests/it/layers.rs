//! Layers on a ground: splitting, energy, closed formulas, and fluxes at depths.

use proptest::prelude::*;
use snowblue_transport::illumination::{Illumination, LightInLayers, light_in_layers, warming_k_h};
use snowblue_transport::ordinates::{
    self, FaceFluxes, HomogeneousMedium, LayeredMedium, MediumFluxes, MediumLayer, OrdinatesOptions, Streams,
};
use snowblue_transport::sample::{GrainSize, SnowSample, TruncatedNormal};
use snowblue_transport::slab::{Estimate, Incidence, Slab};
use snowblue_transport::stack::{Layer, Stack, StackRadiometry};
use snowblue_transport::sunlight::Band;
use snowblue_transport::{HenyeyGreenstein, Scattering};

const STREAMS: usize = 16;
const LIGHTS: [Incidence; 4] = [
    Incidence::Beam { angle_deg: 0.0 },
    Incidence::Beam { angle_deg: 60.0 },
    Incidence::Beam { angle_deg: 89.0 },
    Incidence::Diffuse,
];

fn medium(one_minus_albedo: f64, g: f64) -> HomogeneousMedium {
    HomogeneousMedium::new(&HenyeyGreenstein { one_minus_albedo, asymmetry: g }.scattering(STREAMS), STREAMS)
}

/// Fluxes at every face, [face][light].
fn at_faces(layers: &[(&HomogeneousMedium, f64)], albedo: f64) -> Vec<Vec<FaceFluxes>> {
    let layers: Vec<_> =
        layers.iter().map(|(medium, optical_depth)| MediumLayer { medium, optical_depth: *optical_depth }).collect();
    let layered = LayeredMedium::new(&layers, albedo, &LIGHTS);
    (0..=layers.len()).map(|face| layered.fluxes(face)).collect()
}

fn slab(medium: &HomogeneousMedium, depth: f64) -> Vec<MediumFluxes> {
    medium.fluxes(depth, &LIGHTS.map(|incidence| medium.light(&incidence)))
}

fn assert_near(value: f64, expected: f64, tolerance: f64, what: &str) {
    assert!((value - expected).abs() <= tolerance * expected.abs(), "{what}: {value:e}, expected {expected:e}");
}

/// Media from conservative to black, depths from thin to a transmittance of 10⁻²⁵.
const CASES: [(f64, f64, f64); 10] = [
    (0.0, 0.7, 1e-5),
    (0.0, 0.7, 3.0),
    (0.0, 0.89, 1e4),
    (1e-7, 0.7, 300.0),
    (1e-4, 0.6, 2000.0),
    (1e-3, 0.0, 1000.0),
    (0.3, 0.75, 0.4),
    (0.1, 0.75, 100.0),
    (1.0, 0.0, 8.0),
    (1e-3, 0.8, 2000.0),
];

/// Over black ground one layer has the fluxes of the slab, which is solved by another method.
#[test]
fn one_layer_is_a_slab() {
    for (one_minus_albedo, g, depth) in CASES {
        let medium = medium(one_minus_albedo, g);
        let faces = at_faces(&[(&medium, depth)], 0.0);
        for (light, plain) in slab(&medium, depth).iter().enumerate() {
            let what = format!("1 − ω {one_minus_albedo}, g {g}, τ {depth}, light {light}");
            assert!(
                (faces[0][light].up - plain.reflectance).abs() < 1e-12,
                "R, {what}: {} {}",
                faces[0][light].up,
                plain.reflectance
            );
            assert_near(faces[1][light].down, plain.transmittance, 1e-12, &format!("T, {what}"));
            assert!(faces[1][light].down > 0.0 && (faces[0][light].down - 1.0).abs() < 1e-12, "{what}");
            assert!(faces[1][light].up.abs() <= 1e-15 * faces[1][light].down, "{what}");
        }
    }
}

/// Ten unequal slices of a layer have the fluxes of the layer, and at inner faces those of any other slicing.
#[test]
fn slicing_changes_nothing() {
    for (one_minus_albedo, g, depth) in CASES {
        for albedo in [0.0, 0.6, 1.0] {
            let medium = medium(one_minus_albedo, g);
            let whole = at_faces(&[(&medium, depth)], albedo);
            let fractions = [0.1, 0.02, 0.08, 0.2, 0.1, 0.1, 0.25, 0.05, 1e-9, 0.1 - 1e-9];
            let ten = at_faces(&fractions.map(|fraction| (&medium, fraction * depth)), albedo);
            let five = at_faces(&[0.2, 0.2, 0.2, 0.25, 0.15].map(|fraction| (&medium, fraction * depth)), albedo);
            let pairs = [(0, 0, &whole), (10, 1, &whole), (3, 1, &five), (4, 2, &five), (6, 3, &five), (7, 4, &five)];
            for (face, other_face, other) in pairs {
                for (light, (a, b)) in ten[face].iter().zip(&other[other_face]).enumerate() {
                    let what = format!("1 − ω {one_minus_albedo}, g {g}, τ {depth}, A {albedo}, face {face}, {light}");
                    assert_near(a.down, b.down, 1e-10, &what);
                    assert!((a.up - b.up).abs() <= 1e-10 * b.up + 1e-14 * b.down, "{what}: {a:?} {b:?}");
                    assert!((a.net - b.net).abs() <= 1e-10 * b.net.abs() + 1e-13 * b.down, "{what}: {a:?} {b:?}");
                }
            }
        }
    }
}

/// Slices with separately computed modes, which go through the change of modes, have the fluxes of the layer.
#[test]
fn equal_media_act_as_one_medium() {
    for (one_minus_albedo, g, depth) in CASES {
        let media: Vec<HomogeneousMedium> = (0..4).map(|_| medium(one_minus_albedo, g)).collect();
        let slices: Vec<_> = media.iter().map(|medium| (medium, 0.25 * depth)).collect();
        let (four, whole) = (at_faces(&slices, 0.5), at_faces(&[(&media[0], depth)], 0.5));
        for (light, (top, bottom)) in whole[0].iter().zip(&whole[1]).enumerate() {
            let what = format!("1 − ω {one_minus_albedo}, g {g}, τ {depth}, light {light}");
            assert!(
                (four[0][light].up - top.up).abs() < 1e-12 + 1e-10 * top.up,
                "{what}: {} {}",
                four[0][light].up,
                top.up
            );
            assert_near(four[4][light].down, bottom.down, 1e-10, &what);
        }
    }
}

/// A ground of albedo A under one layer: R + A T T*/(1 − A R*) and T/(1 − A R*), with R* and T* those of the layer
/// under Lambertian light.
#[test]
fn ground_adds_a_geometric_series() {
    for (one_minus_albedo, g, depth) in CASES {
        for albedo in [0.1, 0.5, 0.9] {
            let medium = medium(one_minus_albedo, g);
            let plain = slab(&medium, depth);
            let diffuse = plain[3];
            let faces = at_faces(&[(&medium, depth)], albedo);
            for (light, beam) in plain.iter().enumerate() {
                let arriving = beam.transmittance / (1.0 - albedo * diffuse.reflectance);
                let what = format!("1 − ω {one_minus_albedo}, g {g}, τ {depth}, A {albedo}, light {light}");
                assert_near(faces[1][light].down, arriving, 1e-11, &what);
                let reflected = beam.reflectance + albedo * arriving * diffuse.transmittance;
                assert!((faces[0][light].up - reflected).abs() < 1e-11, "{what}: {} {reflected}", faces[0][light].up);
                assert_near(faces[1][light].up, albedo * faces[1][light].down, 1e-11, &what);
            }
        }
    }
}

/// Without absorption the net flux is equal at every depth, and a white ground reflects everything.
#[test]
fn net_flux_is_constant_in_conservative_stacks() {
    let (loose, dense) = (medium(0.0, 0.6), medium(0.0, 0.85));
    let layers = [(&loose, 0.5), (&dense, 30.0), (&loose, 1e3), (&dense, 2.0), (&loose, 1e-4)];
    for albedo in [0.0, 0.3, 1.0] {
        let faces = at_faces(&layers, albedo);
        for light in 0..LIGHTS.len() {
            for face in &faces {
                let fluxes = face[light];
                assert!((fluxes.net - faces[0][light].net).abs() < 1e-11, "A {albedo}: {fluxes:?}");
                assert!((fluxes.down - fluxes.up - fluxes.net).abs() < 1e-11, "A {albedo}: {fluxes:?}");
            }
            let (reflected, arriving) = (faces[0][light].up, faces[5][light].down);
            assert!((reflected + (1.0 - albedo) * arriving - 1.0).abs() < 1e-11, "A {albedo}: {reflected} {arriving}");
            assert!(albedo < 1.0 || (reflected - 1.0).abs() < 1e-11, "a white ground under white snow: {reflected}");
        }
    }
}

/// With absorption the net flux decreases with depth.
#[test]
fn net_flux_decreases_with_absorption() {
    let (clean, dirty) = (medium(1e-5, 0.7), medium(1e-2, 0.8));
    let layers = [(&clean, 3.0), (&dirty, 1.0), (&clean, 20.0), (&clean, 100.0), (&dirty, 40.0)];
    for albedo in [0.0, 0.8] {
        let faces = at_faces(&layers, albedo);
        for light in 0..LIGHTS.len() {
            assert!(faces.is_sorted_by(|a, b| a[light].net > b[light].net && b[light].net > 0.0), "{faces:?}");
        }
    }
}

/// The transmittance of a stack for Lambertian light is equal from below and from above (van de Hulst 1980, §3.2).
#[test]
fn diffuse_transmittance_is_equal_in_both_directions() {
    let (a, b, c) = (medium(1e-6, 0.7), medium(0.2, 0.85), medium(0.0, -0.2));
    for depths in [[1.0, 0.3, 5.0], [200.0, 30.0, 0.01], [1e-3, 150.0, 1e4]] {
        let upright = [(&a, depths[0]), (&b, depths[1]), (&c, depths[2])];
        let mut reversed = upright;
        reversed.reverse();
        let (upright, reversed) = (at_faces(&upright, 0.0), at_faces(&reversed, 0.0));
        assert_near(upright[3][3].down, reversed[3][3].down, 1e-11, "T");
        // Negative control: the reflectance differs.
        assert!((upright[0][3].up - reversed[0][3].up).abs() > 1e-4);
    }
}

/// Layers without effect and layers without thickness change nothing.
#[test]
fn empty_layers_change_nothing() {
    let (snow, other) = (medium(1e-4, 0.8), medium(0.5, 0.2));
    let clear = HomogeneousMedium::new(&Scattering { one_minus_albedo: 0.0, moments: vec![1.0; STREAMS + 1] }, STREAMS);
    let plain = at_faces(&[(&snow, 20.0)], 0.4);
    let padded = [(&other, 0.0), (&clear, 300.0), (&snow, 20.0), (&other, 1e-300), (&clear, 5.0), (&other, 0.0)];
    let padded = at_faces(&padded, 0.4);
    let bare = at_faces(&[(&other, 0.0)], 0.4);
    for light in 0..LIGHTS.len() {
        assert_near(padded[0][light].up, plain[0][light].up, 1e-12, "R");
        assert_near(padded[6][light].down, plain[1][light].down, 1e-12, "T");
        assert_near(bare[0][light].up, 0.4, 1e-12, "bare ground");
        assert_near(bare[1][light].down, 1.0, 1e-12, "bare ground");
    }
}

fn ordinates_options() -> OrdinatesOptions {
    OrdinatesOptions { tally_rays: 1 << 15, ..OrdinatesOptions::default() }
}

fn winter() -> Stack {
    let fresh = SnowSample {
        grain_size: GrainSize::around(100.0).unwrap(),
        facetness: TruncatedNormal::facetness_around(0.7),
        density_kg_m3: 120.0,
        ..SnowSample::default()
    };
    let old = SnowSample { grain_size: GrainSize::around(800.0).unwrap(), ..SnowSample::default() };
    Stack {
        layers: [(fresh, 3.0), (SnowSample::default(), 7.0), (old, 12.0)]
            .map(|(sample, thickness_cm)| Layer::snow(sample, thickness_cm))
            .to_vec(),
        ground_albedo: 0.2.into(),
        depths_cm: vec![0.0, 1.0, 3.0, 8.0, 22.0],
        incidences: LIGHTS.to_vec(),
        wavelengths_nm: vec![400.0, 550.0, 700.0, 1000.0],
    }
}

/// R + A + (1 − albedo) T = 1, the profile begins with 1 and R and ends with T and albedo · T, and the net flux falls.
#[test]
fn profiles_of_a_snow_pack() {
    let stack = winter();
    let answers = ordinates::solve_stack(&stack, &ordinates_options()).unwrap();
    assert_eq!(answers.len(), 16);
    for StackRadiometry { whole, profile, direct } in &answers {
        let sum =
            whole.fluxes.reflectance.value + whole.fluxes.absorptance.value + 0.8 * whole.fluxes.transmittance.value;
        assert!((sum - 1.0).abs() < 1e-12 && *direct < whole.fluxes.transmittance.value);
        let (first, last) = (&profile[0], &profile[4]);
        assert_near(first.down.value, 1.0, 1e-12, "flux at the top");
        assert_near(first.up.value, whole.fluxes.reflectance.value, 1e-12, "R");
        assert_near(last.down.value, whole.fluxes.transmittance.value, 1e-12, "T");
        assert_near(last.up.value, 0.2 * whole.fluxes.transmittance.value, 1e-11, "what the ground sends back");
        assert!(profile.is_sorted_by(|a, b| a.net.value > b.net.value && b.net.value > 0.0), "{profile:?}");
        assert_eq!(profile.len(), stack.depths_cm.len());
        for at in profile {
            assert!((at.down.value - at.up.value - at.net.value).abs() < 1e-12, "{at:?}");
        }
        let errors = whole.fluxes.to_array().into_iter().chain([last.down, last.e_folding_depth_cm]);
        let errors: Vec<Estimate> = errors.collect();
        // A tally of 2¹⁵ rays has standard errors of 0.1 to several per cent.
        assert!(errors.iter().all(|e| e.standard_error > 0.0 && e.standard_error < 0.2 * e.value), "{errors:?}");
    }
    // Light penetrates deepest into coarse snow, then into loose fine snow, then into denser medium snow; and deeper in
    // the blue than in the infrared.
    let e_folding_depth = |answer: usize, depth: usize| answers[answer].profile[depth].e_folding_depth_cm.value;
    let (fresh, middling, old) = (e_folding_depth(0, 1), e_folding_depth(0, 2), e_folding_depth(0, 4));
    assert!(old > fresh && fresh > middling, "{old} {fresh} {middling}");
    assert!(fresh > 3.0 * e_folding_depth(3, 1));
}

/// The same snow in one layer, in three, or as a slab has the same fluxes and standard errors.
#[test]
fn stacks_of_one_sample_are_slabs() {
    let layer = |thickness_cm| Layer::snow(SnowSample::default(), thickness_cm);
    let denser = SnowSample { density_kg_m3: 600.0, ..SnowSample::default() };
    let one = Stack { layers: vec![layer(15.0)], ground_albedo: 0.0.into(), ..winter() };
    // Half the thickness at twice the density is the same load.
    let three =
        Stack { layers: vec![layer(4.0), Layer::snow(denser, 3.0), layer(5.0)], depths_cm: vec![], ..one.clone() };
    let one = Stack { depths_cm: vec![], ..one };
    let slab = Slab {
        sample: SnowSample::default(),
        thicknesses_cm: vec![15.0],
        incidences: one.incidences.clone(),
        wavelengths_nm: one.wavelengths_nm.clone(),
    };
    let plain = ordinates::solve(&slab, &ordinates_options()).unwrap();
    for (stack, tolerance) in [(one, 1e-12), (three, 1e-10)] {
        let answers = ordinates::solve_stack(&stack, &ordinates_options()).unwrap();
        for (answer, plain) in answers.iter().zip(&plain) {
            assert_eq!((answer.whole.incidence, answer.whole.wavelength_nm), (plain.incidence, plain.wavelength_nm));
            for (a, b) in [
                (answer.whole.fluxes.reflectance, plain.fluxes.reflectance),
                (answer.whole.fluxes.transmittance, plain.fluxes.transmittance),
                (answer.whole.fluxes.absorptance, plain.fluxes.absorptance),
            ] {
                assert!((a.value - b.value).abs() < tolerance * b.value + 1e-14, "{a:?} {b:?}");
                assert_near(a.standard_error, b.standard_error, 1e-6, "standard error");
            }
        }
    }
}

/// Deep in a layer light decays by e over the e-folding depth.
#[test]
fn light_decays_over_the_e_folding_depth() {
    let stack = Stack {
        layers: vec![Layer::snow(SnowSample::default(), 5000.0)],
        depths_cm: vec![1000.0, 1010.0],
        wavelengths_nm: vec![400.0, 700.0],
        ..winter()
    };
    for answer in ordinates::solve_stack(&stack, &ordinates_options()).unwrap() {
        let [upper, lower] = &answer.profile[..] else { panic!("two depths") };
        let measured = 10.0 / (upper.down.value / lower.down.value).ln();
        assert_near(measured, upper.e_folding_depth_cm.value, 1e-6, "e-folding depth");
    }
}

/// A reproducible random choice.
fn choose<T: Copy>(state: &mut u64, of: &[T]) -> T {
    *state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
    of[usize::try_from(*state >> 33).unwrap() % of.len()]
}

/// Automatic streams keep T within 10⁻⁴ of 128 streams on random points of the paper's grid (Varsa & Baranoski 2024,
/// Table 1), all its angles and Lambertian light.
#[test]
fn automatic_streams_suffice_on_the_papers_grid() {
    let mut state = 20_240_101;
    let mut incidences: Vec<Incidence> = (0..9).map(|i| Incidence::Beam { angle_deg: 10.0 * f64::from(i) }).collect();
    incidences.extend([Incidence::Beam { angle_deg: 89.0 }, Incidence::Diffuse]);
    let transmittances = |slab: &Slab, streams: Streams| -> Vec<Estimate> {
        let options = OrdinatesOptions { streams, tally_rays: 1 << 16, seed: 1 };
        ordinates::solve_without_errors(slab, &options).unwrap().iter().map(|row| row.fluxes.transmittance).collect()
    };
    let (mut worst, mut worst_of_eight) = (0.0_f64, 0.0_f64);
    for _ in 0..8 {
        let sample = SnowSample {
            grain_size: GrainSize::around(choose(&mut state, &[100.0, 200.0, 300.0, 400.0, 500.0])).unwrap(),
            facetness: TruncatedNormal::facetness_around(choose(&mut state, &[0.1, 0.3, 0.5, 0.7, 0.9])),
            density_kg_m3: choose(&mut state, &[200.0, 300.0, 400.0]),
            ..SnowSample::default()
        };
        let slab = Slab {
            sample,
            thicknesses_cm: vec![1.0, 3.0, 15.0, 50.0],
            incidences: incidences.clone(),
            wavelengths_nm: vec![choose(&mut state, &[400.0, 450.0, 500.0, 600.0, 700.0])],
        };
        let reference = transmittances(&slab, Streams::Exactly(128));
        let worst_against = |streams| -> f64 {
            let error = |(a, b): (&Estimate, &Estimate)| (a.value / b.value - 1.0).abs();
            transmittances(&slab, streams).iter().zip(&reference).map(error).fold(0.0, f64::max)
        };
        worst = worst.max(worst_against(Streams::Auto));
        worst_of_eight = worst_of_eight.max(worst_against(Streams::Exactly(8)));
    }
    assert!(worst < 1e-4, "{worst}");
    assert!(worst_of_eight > 1e-3, "negative control, 8 streams: {worst_of_eight}");
}

proptest! {
    #![proptest_config(ProptestConfig {
        cases: 200,
        failure_persistence: None,
        rng_seed: proptest::test_runner::RngSeed::Fixed(11),
        ..ProptestConfig::default()
    })]

    /// In any stack of two media fluxes are non-negative and finite, and energy is conserved.
    #[test]
    fn fluxes_in_stacks_are_fractions(
        exponents in prop::array::uniform2(-13.0..0.0_f64), gs in prop::array::uniform2(-0.6..0.999_f64),
        depth_exponents in prop::array::uniform3(-9.0..4.5_f64), albedo in 0.0..=1.0_f64,
    ) {
        let media = [0, 1].map(|i| medium(10_f64.powf(exponents[i]), gs[i]));
        let depths = depth_exponents.map(|exponent| 10_f64.powf(exponent));
        let layers = [(&media[0], depths[0]), (&media[1], depths[1]), (&media[0], depths[2])];
        let faces = at_faces(&layers, albedo);
        for face in &faces {
            for fluxes in face {
                prop_assert!(fluxes.down >= 0.0 && fluxes.down <= 1e7, "{fluxes:?}");
                prop_assert!(fluxes.up >= -1e-12 * fluxes.down, "{fluxes:?}");
                prop_assert!(fluxes.net >= -1e-11 && fluxes.net <= 1.0 + 1e-11, "{fluxes:?}");
                prop_assert!((fluxes.down - fluxes.up - fluxes.net).abs() <= 1e-10, "{fluxes:?}");
            }
        }
        for light in 0..LIGHTS.len() {
            prop_assert!(faces.is_sorted_by(|a, b| a[light].net >= b[light].net - 1e-10), "{faces:?}");
            prop_assert!(faces[0][light].up <= 1.0 + 1e-10);
        }
    }
}

/// Over a layer the net flux falls by the power that is absorbed, (1 − ω) ∫ ϕ dτ, by Simpson's rule.
#[test]
fn what_is_absorbed_is_the_fluence_rate_times_the_absorption() {
    for (one_minus_albedo, g) in [(1e-7, 0.7), (1e-3, 0.8), (0.1, 0.75)] {
        let (above, within) = (medium(1e-4, 0.6), medium(one_minus_albedo, g));
        for (albedo, depth) in [(0.0, 0.3), (0.7, 2.0)] {
            let half = 0.01;
            let layers = [(&above, depth), (&within, half), (&within, half), (&within, 3.0)]
                .map(|(medium, optical_depth)| MediumLayer { medium, optical_depth });
            let layered = LayeredMedium::new(&layers, albedo, &LIGHTS);
            let [first, middle, last] = [1, 2, 3].map(|face| layered.fluence_rates(face));
            let (top, bottom) = (layered.fluxes(1), layered.fluxes(3));
            for light in 0..LIGHTS.len() {
                let mean = (first[light] + 4.0 * middle[light] + last[light]) / 6.0;
                let absorbed = top[light].net - bottom[light].net;
                // The light of the beam at 89° decays within 0.02 of optical depth, which the rule follows to 1e-3.
                let tolerance = if light == 2 { 1e-3 } else { 1e-6 } + 1e-15 / absorbed;
                assert_near(absorbed, one_minus_albedo * 2.0 * half * mean, tolerance, &format!("light {light}"));
            }
        }
    }
}

/// Where nothing scatters back, the fluence rate on top is that of the light alone: 1/μ₀, and 2 under a white sky. A
/// white ground under no snow sends back 2 more.
#[test]
fn fluence_rates_have_their_limits() {
    let clear = medium(1.0, 0.0);
    for (albedo, ground) in [(0.0, 0.0), (1.0, 2.0)] {
        let layer = MediumLayer { medium: &clear, optical_depth: 0.0 };
        let rates = LayeredMedium::new(&[layer], albedo, &LIGHTS).fluence_rates(0);
        for (rate, light) in rates.iter().zip(LIGHTS) {
            let alone = match light {
                Incidence::Beam { angle_deg } => 1.0 / angle_deg.to_radians().cos(),
                Incidence::Diffuse => 2.0,
            };
            assert_near(*rate, alone + ground, 1e-12, &format!("{light} on albedo {albedo}"));
        }
    }
    // Isotropic light in the middle of an endless white box: four times the flux through a plane.
    let white = medium(0.0, 0.7);
    let layer = |optical_depth| MediumLayer { medium: &white, optical_depth };
    let layered = LayeredMedium::new(&[layer(500.0), layer(500.0)], 1.0, &LIGHTS);
    for (rate, fluxes) in layered.fluence_rates(1).iter().zip(layered.fluxes(1)) {
        assert_near(*rate, 4.0 * fluxes.down, 1e-9, "isotropic");
    }
}

/// A half-space under a layer is the limit of a thick layer.
#[test]
fn the_last_layer_may_be_a_half_space() {
    let pack = |thickness_cm: f64| Stack { layers: vec![Layer { thickness_cm, ..winter().layers[1] }], ..winter() };
    let on_top = |thickness_cm: f64| {
        let mut layers = vec![winter().layers[0]];
        layers.extend(pack(thickness_cm).layers);
        let stack = Stack { layers, depths_cm: vec![0.0, 1.0, 10.0], ..winter() };
        ordinates::solve_stack_without_errors(&stack, &ordinates_options()).unwrap()
    };
    for (endless, thick) in on_top(f64::INFINITY).iter().zip(on_top(1e5)) {
        assert_near(endless.whole.fluxes.reflectance.value, thick.whole.fluxes.reflectance.value, 1e-12, "R");
        assert_eq!(endless.whole.fluxes.transmittance.value.to_bits(), 0.0_f64.to_bits());
        for (at, other) in endless.profile.iter().zip(&thick.profile) {
            assert_near(at.down.value, other.down.value, 1e-10, "down");
            assert_near(at.fluence.value, other.fluence.value, 1e-10, "fluence");
        }
    }
}

/// What the layers absorb, what leaves the top and what the ground keeps is what falls on the snow, spectrally, in
/// bands, and over a day; and the power per volume at depth is that between two depths.
#[test]
fn light_in_layers_is_conserved() {
    let wavelengths_nm: Vec<f64> = (40..=100).map(|tens| 10.0 * f64::from(tens)).collect();
    let light = |elevation_deg, direct, diffuse| {
        Illumination::under_sun(elevation_deg, vec![direct; wavelengths_nm.len()], vec![diffuse; wavelengths_nm.len()])
    };
    let half_cm = 1e-3;
    let depths_cm = vec![0.0, 1.0 - half_cm, 1.0, 1.0 + half_cm, 22.0];
    let stack = Stack { depths_cm, wavelengths_nm: wavelengths_nm.clone(), ..winter() };
    let lights = [light(40.0, 1.0, 0.3), light(-5.0, 0.0, 0.0), light(40.0, 0.5, 0.0), light(0.001, 0.1, 0.2)];
    let solved = light_in_layers(&stack, &lights, &ordinates_options()).unwrap();
    for (Illumination { direct, diffuse, .. }, light) in lights.iter().zip(&solved) {
        let incident: Vec<f64> = direct.iter().zip(diffuse).map(|(direct, diffuse)| direct + diffuse).collect();
        let (count, ground) = (wavelengths_nm.len(), 4 * wavelengths_nm.len());
        for (nm, incident) in incident.iter().enumerate() {
            assert!((light.levels[nm].down - incident).abs() < 1e-12);
            let absorbed: f64 = light.absorbed.iter().skip(nm).step_by(count).sum();
            let sum = light.levels[nm].up + absorbed + 0.8 * light.levels[ground + nm].down;
            assert!((sum - incident).abs() < 1e-12, "{sum}");
            let [above, at, below] = [1, 2, 3].map(|depth| light.levels[depth * count + nm]);
            let power = (above.net - below.net) / (0.02 * half_cm);
            // The rounding of the difference, and the curvature over 20 µm.
            assert!((power - at.absorbed_per_m).abs() < 1e-4 * power + 1e-9, "{power} {}", at.absorbed_per_m);
        }
        let visible = light.band(Band::Visible, &wavelengths_nm).unwrap();
        let kept = visible.levels[0].net - visible.levels[4].net;
        assert!((visible.absorbed.iter().sum::<f64>() - kept).abs() < 1e-9);
        // 1 W m⁻² nm⁻¹ from 400 to 700 nm are 165000 nm² /(h c N_A) photons.
        let par = light.band(Band::Par, &wavelengths_nm).unwrap();
        assert!((par.levels[0].down - 165_000.0 * 8.359_35e-3 * incident[0]).abs() < 1e-3, "{}", par.levels[0].down);
    }
    assert!(solved[1].levels.iter().all(|level| level.values().iter().all(|value| value.to_bits() == 0)));
    let day = LightInLayers::sum_of_day(&solved[..2]);
    assert!((day.levels[3].actinic - 43_200.0 * solved[0].levels[3].actinic).abs() < 1e-6);
    // Warming of a layer is that of its power, and wet snow melts.
    let band = solved[0].band(Band::Visible, &wavelengths_nm).unwrap();
    let [_, layers] = band.warming_k_h(&stack);
    let expected = 3600.0 * band.absorbed[1] / (0.07 * 300.0 * (152.5 + 7.122 * 268.15));
    assert_near(layers[1], expected, 1e-12, "warming");
    // A half-space keeps what arrives at it, and has no power per volume.
    let mut endless = Stack { depths_cm: vec![0.0], ..stack };
    if let Some(layer) = endless.layers.last_mut() {
        layer.thickness_cm = f64::INFINITY;
    }
    let solved = light_in_layers(&endless, &lights[..1], &ordinates_options()).unwrap();
    let band = solved[0].band(Band::Visible, &wavelengths_nm).unwrap();
    assert_near(band.absorbed.iter().sum(), band.levels[0].net, 1e-9, "absorbed by a half-space");
    let [at_depths, of_layers] = band.warming_k_h(&endless);
    let last = of_layers.len() - 1;
    assert!(at_depths[0] > 0.0 && of_layers[last].is_nan() && of_layers[..last].iter().all(|k_h| *k_h > 0.0));
    assert!(band.absorbed_per_m_of_layers(&endless)[last].is_nan() && band.absorbed[last] > 0.0);
    let wet = SnowSample { water_saturation: 0.1, ..SnowSample::default() };
    assert!(warming_k_h(1.0, &wet).is_nan());
}
