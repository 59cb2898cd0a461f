//! Others' numbers, with their place.

use snowblue_transport::ordinates::{Fluxes, HomogeneousMedium, Scattering};

/// A Henyey–Greenstein slab under a beam.
fn henyey_greenstein(one_minus_albedo: f64, g: f64, depth: f64, cos_incidence: f64, streams: usize) -> Fluxes {
    let medium = HomogeneousMedium::new(&Scattering::henyey_greenstein(one_minus_albedo, g, streams), streams);
    medium.fluxes(depth, &[medium.beam(cos_incidence)])[0]
}

/// van de Hulst (1980), *Multiple Light Scattering*, Table 35: g = .75, ω = .9, τ = 2, normal incidence. Five figures.
#[test]
fn van_de_hulst_slab() {
    let fluxes = henyey_greenstein(0.1, 0.75, 2.0, 1.0, 32);
    assert!((fluxes.reflectance - 0.09739).abs() < 5e-6, "{fluxes:?}");
    assert!((fluxes.transmittance - 0.66096).abs() < 5e-6, "{fluxes:?}");
}

/// Slabs computed in 50-digit arithmetic with the same discretisation (32 streams, double Gauss, δ-M), printed with 12
/// figures. What differs is rounding and the print, so the tolerance is 1e-11, also where T is 1e-20.
#[test]
fn reference_slabs() {
    let table = include_str!("data/slabs_henyey_greenstein.csv");
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
