//! Published values, with their sources.

use snowblue_transport::ordinates::{HomogeneousMedium, LayeredMedium, MediumFluxes, MediumLayer};
use snowblue_transport::slab::Incidence;
use snowblue_transport::{HenyeyGreenstein, Scattering};

/// A Henyey–Greenstein slab under a beam.
fn henyey_greenstein(one_minus_albedo: f64, g: f64, depth: f64, cos_incidence: f64, streams: usize) -> MediumFluxes {
    let medium =
        HomogeneousMedium::new(&HenyeyGreenstein { one_minus_albedo, asymmetry: g }.scattering(streams), streams);
    medium.fluxes(depth, &[medium.beam(cos_incidence)])[0]
}

/// van de Hulst (1980), *Multiple Light Scattering*, Table 35: g = 0.75, ω = 0.9, τ = 2, normal incidence. Five
/// figures.
#[test]
fn van_de_hulst_slab() {
    let fluxes = henyey_greenstein(0.1, 0.75, 2.0, 1.0, 32);
    assert!((fluxes.reflectance - 0.09739).abs() < 5e-6, "{fluxes:?}");
    assert!((fluxes.transmittance - 0.66096).abs() < 5e-6, "{fluxes:?}");
}

/// Slabs computed in 50-digit arithmetic with the same discretisation (32 streams, double Gauss, δ-M), printed with 12
/// figures. Only rounding differs, so the relative tolerance is 1e-11, also where T is 1e-20.
#[test]
fn reference_slabs() {
    let table = include_str!("../data/slabs_henyey_greenstein.csv");
    let mut rows = 0;
    for line in table.lines().skip(1) {
        let v: Vec<f64> = line.split(',').map(|field| field.parse().unwrap()).collect();
        let fluxes = henyey_greenstein(v[0], v[1], v[2], v[3], 32);
        assert!((fluxes.reflectance / v[4] - 1.0).abs() < 1e-11, "{line}: {fluxes:?}");
        assert!((fluxes.transmittance / v[5] - 1.0).abs() < 1e-11, "{line}: {fluxes:?}");
        rows += 1;
    }
    assert_eq!(rows, 36);
}

/// Fluxes down and up at each face of layers (1 − ω, τ) with common moments, on 8 streams under Lambertian light.
fn layers_of_eight_streams(layers: &[(f64, f64)], moments: &[f64; 9]) -> Vec<[f64; 2]> {
    let media: Vec<HomogeneousMedium> = layers
        .iter()
        .map(|(one_minus_albedo, _)| Scattering { one_minus_albedo: *one_minus_albedo, moments: moments.to_vec() })
        .map(|scattering| HomogeneousMedium::new(&scattering, 8))
        .collect();
    let pile = media.iter().zip(layers).map(|(medium, (_, depth))| MediumLayer { medium, optical_depth: *depth });
    let pile: Vec<_> = pile.collect();
    let pile = LayeredMedium::new(&pile, 0.0, &[Incidence::Diffuse]);
    (0..=layers.len()).map(|face| pile.fluxes(face)[0]).map(|fluxes| [fluxes.down, fluxes.up]).collect()
}

/// Asserts six printed figures; the last one is uncertain, from single precision.
fn assert_fluxes(found: [f64; 2], printed: [f64; 2]) {
    for (value, expected) in found.into_iter().zip(printed) {
        assert!((value - expected).abs() <= 5e-6 * expected + 1e-15, "{found:?}, printed {printed:?}");
    }
}

/// Two isotropic layers: Ozisik & Shouman (1980, J. Quant. Spectrosc. Radiat. Transfer 24, 441), Table 1, lines 4, 1
/// and 13, with the figures that the test programme of DISORT (Stamnes et al. 2000, tests 8a–c) prints for 8 streams.
#[test]
fn two_isotropic_layers() {
    let isotropic = [1.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0];
    for (layers, printed) in [
        ([(0.5, 0.25), (0.7, 0.25)], [[1.0, 9.29634e-2], [7.22235e-1, 2.78952e-2], [5.13132e-1, 0.0]]),
        ([(0.2, 0.25), (0.05, 0.25)], [[1.0, 2.25136e-1], [7.95332e-1, 1.26349e-1], [6.50417e-1, 0.0]]),
        ([(0.2, 1.0), (0.05, 2.0)], [[1.0, 3.78578e-1], [4.86157e-1, 2.43397e-1], [1.59984e-1, 0.0]]),
    ] {
        let found = layers_of_eight_streams(&layers, &isotropic);
        found.into_iter().zip(printed).for_each(|(found, printed)| assert_fluxes(found, printed));
    }
}

/// Six layers of depth l and albedo 0.6 + 0.05 l, isotropic and with forward scattering: Devaux, Grandjean, Ishiguro &
/// Siewert (1979, Astrophys. Space Sci. 62, 225), Tables VI and VII, with the figures of DISORT's tests 9a and 9b at
/// the depths 0, 1.05, 2.1, 6 and 21.
#[test]
fn six_layers() {
    let layers = [(0.35, 1.0), (0.3, 0.05), (0.3, 1.05), (0.3, 0.9), (0.25, 3.0), (0.2, 4.0), (0.15, 5.0), (0.1, 6.0)];
    let isotropic = [1.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0];
    let times_odd = [1.0, 2.00916, 1.56339, 0.67407, 0.22215, 0.04725, 0.00671, 0.00068, 0.00005];
    let mut forward = times_odd;
    for (moment, l) in forward.iter_mut().zip(0_u8..) {
        *moment /= f64::from(2 * l + 1);
    }
    let printed_isotropic = [
        [1.0, 2.27973e-1],
        [3.55151e-1, 8.75098e-2],
        [1.44265e-1, 3.61819e-2],
        [6.71445e-3, 2.19291e-3],
        [6.16968e-7, 0.0],
    ];
    let printed_forward = [
        [1.0, 1.00079e-1],
        [4.52357e-1, 4.52014e-2],
        [2.36473e-1, 2.41941e-2],
        [2.76475e-2, 4.16016e-3],
        [7.41853e-5, 0.0],
    ];
    for (moments, printed) in [(isotropic, printed_isotropic), (forward, printed_forward)] {
        let found = layers_of_eight_streams(&layers, &moments);
        for (face, printed) in [0, 2, 3, 5, 8].into_iter().zip(printed) {
            assert_fluxes(found[face], printed);
        }
    }
}
