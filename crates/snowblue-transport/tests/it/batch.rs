//! Batches of slabs: each has the numbers that it has alone.

use std::sync::atomic::{AtomicUsize, Ordering};

use snowblue_transport::batch::{Batch, SlabCase};
use snowblue_transport::monte_carlo::{self, MonteCarloOptions};
use snowblue_transport::ordinates::{self, OrdinatesOptions};
use snowblue_transport::slab::{Estimate, Fluxes};
use snowblue_transport::stack::{Layer, Stack};
use snowblue_transport::{
    GrainSize, GroundAlbedo, Impurities, Incidence, Slab, SnowSample, Substance, TransportError, TruncatedNormal,
    Variable,
};

const OPTIONS: OrdinatesOptions = OrdinatesOptions { tally_rays: 1 << 10, streams: ordinates::Streams::Auto, seed: 1 };

/// Samples of different sizes, shapes, water and impurities.
fn samples() -> Vec<SnowSample> {
    let of_area = |area_m2_kg| GrainSize::from_specific_surface_area(area_m2_kg, -5.0).unwrap();
    let usual = SnowSample { grain_size: of_area(40.0), ..SnowSample::default() };
    vec![
        usual,
        SnowSample { grain_size: of_area(2.0), density_kg_m3: 450.0, ..usual },
        SnowSample { impurities: Impurities::none().with(Substance::BLACK_CARBON, 80.0), ..usual },
        SnowSample { facetness: TruncatedNormal::exactly(0.5), ..usual },
        SnowSample { grain_size: of_area(10.0), water_saturation: 0.1, ..usual },
        SnowSample::default(),
    ]
}

fn batch() -> Batch {
    let beam = |angle_deg| Incidence::Beam { angle_deg };
    let lights = [beam(0.0), Incidence::Diffuse, beam(86.0), beam(40.0), beam(0.0), beam(60.0)];
    let case = |sample, thickness_cm, incidence, ground_albedo| SlabCase {
        sample,
        thickness_cm,
        incidence,
        ground_albedo: f64::into(ground_albedo),
    };
    let mut cases: Vec<SlabCase> =
        lights.iter().enumerate().map(|(sample, light)| case(sample, 3.0 + sample as f64, *light, 0.0)).collect();
    // The same samples again, in another order, and on grounds.
    cases.extend([case(4, 1.0, beam(85.0), 0.0), case(0, 9.0, beam(0.0), 0.0), case(1, 2.0, beam(30.0), 0.7)]);
    Batch { samples: samples(), cases, wavelengths_nm: vec![450.0, 700.0, 1100.0] }
}

fn bits(fluxes: &[Fluxes]) -> Vec<u64> {
    let of = |Estimate { value, standard_error }: Estimate| [value.to_bits(), standard_error.to_bits()];
    fluxes.iter().flat_map(|at| at.to_array().map(of)).flatten().collect()
}

#[test]
fn every_slab_has_the_bits_that_it_has_alone() {
    let batch = batch();
    let together = ordinates::solve_batch(&batch, &OPTIONS, true, &|_| ()).unwrap();
    for (case, fluxes) in batch.cases.iter().zip(together.chunks(batch.wavelengths_nm.len())) {
        let sample = batch.samples[case.sample];
        let rows = if case.ground_albedo.reflects() {
            let stack = Stack {
                layers: vec![Layer::snow(sample, case.thickness_cm)],
                ground_albedo: case.ground_albedo.clone(),
                depths_cm: Vec::new(),
                incidences: vec![case.incidence],
                wavelengths_nm: batch.wavelengths_nm.clone(),
            };
            ordinates::solve_stack(&stack, &OPTIONS).unwrap().into_iter().map(|answer| answer.whole).collect()
        } else {
            let slab = Slab {
                sample,
                thicknesses_cm: vec![case.thickness_cm],
                incidences: vec![case.incidence],
                wavelengths_nm: batch.wavelengths_nm.clone(),
            };
            ordinates::solve(&slab, &OPTIONS).unwrap()
        };
        let alone: Vec<Fluxes> = rows.iter().map(|row| row.fluxes).collect();
        if !case.ground_albedo.reflects() {
            assert_eq!(bits(fluxes), bits(&alone), "{case:?}");
        }
        // A stack has its errors by the adjoint equations, which round differently.
        for (one, other) in
            fluxes.iter().zip(&alone).flat_map(|(one, other)| one.to_array().into_iter().zip(other.to_array()))
        {
            assert_eq!(one.value.to_bits(), other.value.to_bits(), "{case:?}");
            assert!((one.standard_error / other.standard_error - 1.0).abs() < 1e-8, "{one:?} {other:?}");
        }
    }
}

#[test]
fn the_order_of_slabs_does_not_change_a_bit() {
    let batch = batch();
    let count = batch.wavelengths_nm.len();
    let solve = |batch: &Batch| ordinates::solve_batch(batch, &OPTIONS, false, &|_| ()).unwrap();
    let reversed = Batch { cases: batch.cases.iter().rev().cloned().collect(), ..batch.clone() };
    let back: Vec<Fluxes> = solve(&reversed).chunks(count).rev().flatten().copied().collect();
    assert_eq!(bits(&solve(&batch)), bits(&back));
}

#[test]
fn progress_counts_the_slabs() {
    let most = AtomicUsize::new(0);
    let report = |done| {
        most.fetch_max(done, Ordering::Relaxed);
    };
    let batch = batch();
    ordinates::solve_batch(&batch, &OPTIONS, false, &report).unwrap();
    assert_eq!(most.into_inner(), batch.cases.len());
    let nothing = Batch { cases: Vec::new(), ..batch };
    assert_eq!(ordinates::solve_batch(&nothing, &OPTIONS, false, &|_| ()), Ok(Vec::new()));
}

/// Over a half-space nothing is transmitted, and 1 km of snow is one at 1100 nm. Only the rounding differs.
#[test]
fn a_half_space_is_the_limit_of_thick_slabs() {
    for (ground_albedo, tolerance) in [(0.0, 1e-12), (0.9, 1e-9)] {
        let case = |thickness_cm, incidence| SlabCase {
            sample: 0,
            thickness_cm,
            incidence,
            ground_albedo: f64::into(ground_albedo),
        };
        let lights = [Incidence::Diffuse, Incidence::Beam { angle_deg: 50.0 }];
        let cases = [f64::INFINITY, 1e5].iter().flat_map(|h| lights.map(|light| case(*h, light))).collect();
        let batch = Batch { samples: samples(), cases, wavelengths_nm: vec![1100.0] };
        let solved = ordinates::solve_batch(&batch, &OPTIONS, false, &|_| ()).unwrap();
        for light in 0..2 {
            let [half_space, thick] = [solved[light], solved[2 + light]];
            assert!(half_space.transmittance.value.abs() < f64::MIN_POSITIVE);
            assert!((half_space.reflectance.value - thick.reflectance.value).abs() < tolerance);
            assert!((half_space.absorptance.value + half_space.reflectance.value - 1.0).abs() < 1e-12);
        }
    }
}

#[test]
fn random_walks_have_the_bits_of_single_slabs_and_stacks() {
    let options = MonteCarloOptions { rays: 200, seed: 1, per_wavelength: false };
    let beam = Incidence::Beam { angle_deg: 30.0 };
    let case = |sample, thickness_cm, incidence, ground_albedo| SlabCase {
        sample,
        thickness_cm,
        incidence,
        ground_albedo: f64::into(ground_albedo),
    };
    let cases = vec![
        case(0, 1.0, beam, 0.0),
        case(1, 2.0, beam, 0.5),
        case(0, 1.0, Incidence::Diffuse, 0.0),
        case(0, 4.0, beam, 0.0),
        case(0, 4.0, Incidence::Diffuse, 0.0),
    ];
    let batch = Batch { samples: samples(), cases, wavelengths_nm: vec![500.0, 900.0] };
    let solved = monte_carlo::solve_batch(&batch, &options, &|_| ()).unwrap();
    let slab = Slab {
        sample: batch.samples[0],
        thicknesses_cm: vec![1.0, 4.0],
        incidences: vec![beam, Incidence::Diffuse],
        wavelengths_nm: batch.wavelengths_nm.clone(),
    };
    let rows = monte_carlo::solve(&slab, &options, &|_| ()).unwrap();
    for (place, number) in [0, 2, 3, 4].into_iter().enumerate() {
        for wavelength in 0..2 {
            assert_eq!(
                solved[2 * number + wavelength].transmittance,
                rows[2 * place + wavelength].fluxes.transmittance
            );
        }
    }
    let stack = Stack {
        layers: vec![Layer::snow(batch.samples[1], 2.0)],
        ground_albedo: 0.5.into(),
        depths_cm: Vec::new(),
        incidences: vec![beam],
        wavelengths_nm: batch.wavelengths_nm.clone(),
    };
    assert_eq!(
        solved[2].reflectance,
        monte_carlo::solve_stack(&stack, &options, &|_| ()).unwrap()[0].fluxes.reflectance
    );
    let endless = Batch { cases: vec![case(0, 1.0, beam, 0.0), case(0, f64::INFINITY, beam, 0.0)], ..batch };
    let wrong = monte_carlo::solve_batch(&endless, &options, &|_| ()).unwrap_err();
    assert!(wrong.case == Some(1) && matches!(wrong.error, TransportError::Range(_)), "{wrong}");
}

/// More snows than are solved at once.
#[test]
fn thousands_of_snows_stay_in_order() {
    let samples: Vec<SnowSample> =
        (0..2100).map(|i| SnowSample { density_kg_m3: 100.0 + 0.25 * f64::from(i), ..SnowSample::default() }).collect();
    let case = |sample| SlabCase { sample, ..batch().cases[0].clone() };
    let of = |samples: &[SnowSample]| {
        let cases = (0..samples.len()).map(case).collect();
        let batch = Batch { samples: samples.to_vec(), cases, wavelengths_nm: vec![600.0] };
        ordinates::solve_batch(&batch, &OPTIONS, false, &|_| ()).unwrap()
    };
    let all = of(&samples);
    for place in [0, 1023, 1024, 2047, 2048, 2099] {
        assert_eq!(bits(&all[place..=place]), bits(&of(&samples[place..=place])), "{place}");
    }
}

/// At each wavelength the ground has the albedo that its spectrum has there: slabs, layers, their derivatives and
/// random walks have the bits of a grey ground of that albedo.
#[test]
fn a_spectrum_as_ground_is_grey_at_each_wavelength() {
    let wavelengths_nm = vec![450.0, 700.0, 1100.0];
    let soil = GroundAlbedo::spectrum(vec![400.0, 500.0, 700.0, 1200.0], vec![0.0, 0.1, 0.5, 0.5]).unwrap();
    let albedos = [0.05, 0.5, 0.5];
    let variables = [Variable::GroundAlbedo, Variable::Thickness];
    let incidences = vec![Incidence::Diffuse, Incidence::Beam { angle_deg: 60.0 }];
    let stack = |ground_albedo: GroundAlbedo| Stack {
        layers: vec![Layer::snow(samples()[0], 2.0), Layer::snow(samples()[1], 1.0)],
        ground_albedo,
        depths_cm: vec![1.0, 3.0],
        incidences: incidences.clone(),
        wavelengths_nm: wavelengths_nm.clone(),
    };
    let batch = |ground_albedo: GroundAlbedo| Batch {
        samples: samples()[..1].to_vec(),
        cases: incidences
            .iter()
            .map(|incidence| SlabCase {
                sample: 0,
                thickness_cm: 2.0,
                incidence: *incidence,
                ground_albedo: ground_albedo.clone(),
            })
            .collect(),
        wavelengths_nm: wavelengths_nm.clone(),
    };
    let walks = MonteCarloOptions { rays: 100, seed: 1, per_wavelength: false };
    let of_ground = |ground: GroundAlbedo| {
        let layers = ordinates::differentiate_stack(&stack(ground.clone()), &variables, &OPTIONS, true).unwrap();
        let slabs =
            ordinates::differentiate_batch(&batch(ground.clone()), &variables, &OPTIONS, true, &|_| ()).unwrap();
        let walked = monte_carlo::solve_stack(&stack(ground), &walks, &|_| ()).unwrap();
        // In text, since some errors are NaN.
        let text = |row: usize| {
            let of = |per_row: usize| row * per_row..(row + 1) * per_row;
            format!("{:?} {:?}", layers.fluxes[row], &layers.derivatives[of(layers.derivatives.len() / 6)])
                + &format!("{:?} {:?} {:?}", slabs.fluxes[row], &slabs.derivatives[of(2)], walked[row])
        };
        [0, 1, 2, 3, 4, 5].map(text)
    };
    let spectrum = of_ground(soil);
    for (place, albedo) in albedos.into_iter().enumerate() {
        let grey = of_ground(albedo.into());
        assert_eq!([&spectrum[place], &spectrum[3 + place]], [&grey[place], &grey[3 + place]], "{albedo}");
        let other = usize::from(place == 0);
        assert_ne!(spectrum[other], grey[other], "the ground makes a difference");
    }
}

#[test]
fn a_ground_must_be_known_at_all_wavelengths() {
    let soil = GroundAlbedo::spectrum(vec![400.0, 1000.0], vec![0.1, 0.3]).unwrap();
    let mut batch = batch();
    batch.cases[1].ground_albedo = soil.clone();
    let error = batch.check().unwrap_err();
    assert_eq!(error.case, Some(1));
    assert_eq!(error.to_string(), "wavelength above the ground is 1100 nm, but must lie in 400–1000 nm");
    let stack = Stack {
        layers: vec![Layer::snow(samples()[0], 2.0)],
        ground_albedo: soil,
        depths_cm: Vec::new(),
        incidences: vec![Incidence::Diffuse],
        wavelengths_nm: vec![350.0],
    };
    assert!(ordinates::solve_stack(&stack, &OPTIONS).is_err());
}

/// Stacks of several kinds of grains, dry and wet, under several lights: each has the numbers that it has alone.
#[test]
fn every_stack_has_the_bits_that_it_has_alone() {
    let of = |own: &[usize], angles_deg: &[f64], depths_cm: &[f64]| Stack {
        layers: own.iter().map(|sample| Layer::snow(samples()[*sample], 2.0 + *sample as f64)).collect(),
        ground_albedo: 0.3.into(),
        depths_cm: depths_cm.to_vec(),
        incidences: angles_deg.iter().map(|angle_deg| Incidence::Beam { angle_deg: *angle_deg }).collect(),
        wavelengths_nm: vec![450.0, 1100.0],
    };
    let stacks = [of(&[0, 1], &[60.0], &[1.0]), of(&[1], &[0.0, 86.0], &[]), of(&[2, 3, 0], &[30.0], &[0.0, 4.0])];
    let variables = [Variable::Thickness, Variable::GroundAlbedo];
    let done = AtomicUsize::new(0);
    let progress = |_: usize| {
        done.fetch_add(1, Ordering::Relaxed);
    };
    let together = ordinates::differentiate_stacks(&stacks, &variables, &OPTIONS, true, &progress).unwrap();
    assert_eq!(done.into_inner(), stacks.len());
    for (stack, solved) in stacks.iter().zip(&together) {
        assert_eq!(solved, &ordinates::differentiate_stack(stack, &variables, &OPTIONS, true).unwrap());
    }
    let wrong = Stack { depths_cm: vec![99.0], ..stacks[1].clone() };
    let error = ordinates::differentiate_stacks(&[stacks[0].clone(), wrong], &[], &OPTIONS, false, &|_| ());
    assert_eq!(error.unwrap_err().case, Some(1));
}
