//! Bidirectional reflectance by ordinates: random walks, reciprocity, and the albedo.

use std::f64::consts::PI;

use snowblue_stat::{sidak_level, z_p_value};
use snowblue_transport::monte_carlo::{self, GoniometricOptions, PatchGrid};
use snowblue_transport::optics::{Impurities, Substance};
use snowblue_transport::ordinates::{self, OrdinatesOptions, Views, bidirectional};
use snowblue_transport::quadrature::Quadrature;
use snowblue_transport::slab::Estimate;
use snowblue_transport::{GrainSize, Incidence, Layer, Slab, SnowSample, Stack};

fn beam(angle_deg: f64) -> Incidence {
    Incidence::Beam { angle_deg }
}

/// Fine snow on coarse, wet snow on a ground.
fn pack() -> Stack {
    let fine = SnowSample { grain_size: GrainSize::around(150.0).unwrap(), ..SnowSample::default() };
    let grain_size = GrainSize::around(900.0).unwrap();
    let coarse = SnowSample { grain_size, water_saturation: 0.2, ..SnowSample::default() };
    Stack {
        layers: vec![Layer::snow(fine, 0.3), Layer::snow(coarse, 2.0)],
        ground_albedo: 0.4.into(),
        depths_cm: Vec::new(),
        incidences: vec![beam(0.0), beam(65.0), Incidence::Diffuse],
        wavelengths_nm: vec![500.0, 1030.0, 1300.0],
    }
}

/// Each patch within the noise of random walks, which absorb little or much light, in reflection and transmission.
#[test]
fn patches_agree_with_random_walks() {
    let dust = Impurities::none().with(Substance::SAHARAN_DUST, 1e6);
    let fine = PatchGrid { rings: 6, sectors: 6 };
    for (incidence, patches, impurities) in [
        (beam(0.0), fine, Impurities::none()),
        (beam(60.0), fine, Impurities::none()),
        (beam(60.0), PatchGrid { rings: 3, sectors: 4 }, dust),
        (Incidence::Diffuse, PatchGrid { rings: 6, sectors: 1 }, Impurities::none()),
    ] {
        let slab = Slab {
            sample: SnowSample { impurities, ..SnowSample::default() },
            thicknesses_cm: vec![0.5],
            incidences: vec![incidence],
            wavelengths_nm: vec![500.0, 1300.0],
        };
        let solved = ordinates::distribute(&slab, patches, &OrdinatesOptions::default()).unwrap();
        let options = GoniometricOptions { rays: 200_000, seed: 3, patches };
        let walked = monte_carlo::distribute(&slab, &options, &|_| ()).unwrap();
        for (solved, walked) in solved.iter().zip(&walked) {
            assert_eq!((solved.incidence, solved.wavelength_nm), (walked.incidence, walked.wavelength_nm));
            let sides = solved.reflection.iter().chain(&solved.transmission);
            for (exact, found) in sides.zip(walked.reflection.iter().chain(&walked.transmission)) {
                let (exact, Estimate { value, standard_error }) = (exact.bsdf_per_sr.value, found.bsdf_per_sr);
                // The rays through grains of the ordinates have an error of 1 % of single scattering.
                let p = z_p_value((value - exact) / standard_error.hypot(0.01 * exact));
                assert!(p > sidak_level(1e-3, 4 * 84), "{incidence} {}: {exact} {found:?}", solved.wavelength_nm);
            }
        }
    }
}

/// The flux of the radiances is the reflectance, whose azimuth-averaged solution has other streams.
#[test]
fn radiances_sum_to_the_reflectance() {
    let rule = Quadrature::half_range(24);
    let zeniths_deg = rule.cosines.iter().map(|mu| mu.acos().to_degrees()).collect();
    let views = Views { zeniths_deg, azimuths_deg: (0..36).map(|step| 10.0 * f64::from(step)).collect() };
    let stack = pack();
    let options = OrdinatesOptions::default();
    let fluxes = ordinates::solve_stack(&stack, &options).unwrap();
    for (light, fluxes) in bidirectional(&stack, &views, &options).unwrap().iter().zip(&fluxes) {
        let flux = |radiances: &[f64]| -> f64 {
            let rings = radiances.chunks(36).zip(rule.cosines.iter().zip(&rule.weights));
            rings.map(|(ring, (mu, weight))| 2.0 * PI * mu * weight * ring.iter().sum::<f64>() / 36.0).sum()
        };
        let expected = fluxes.whole.fluxes;
        // Single scattering by other rays through grains, in bins.
        let reflected = flux(&light.reflection) / expected.reflectance.value;
        assert!((reflected - 1.0).abs() < 3e-3, "{reflected} {:?}", fluxes.whole);
        let transmitted = (flux(&light.transmission) + fluxes.direct) / expected.transmittance.value;
        assert!((transmitted - 1.0).abs() < 3e-3, "{transmitted} {:?}", fluxes.whole);
    }
}

#[test]
fn reflectance_is_reciprocal() {
    let angles = [12.0, 50.0, 80.0];
    let views = Views { zeniths_deg: angles.to_vec(), azimuths_deg: vec![0.0, 40.0, 180.0] };
    let stack = Stack { incidences: angles.map(beam).to_vec(), ..pack() };
    let options = OrdinatesOptions { tally_rays: 1 << 14, ..OrdinatesOptions::default() };
    let solved = bidirectional(&stack, &views, &options).unwrap();
    let at = |incidence: usize, zenith: usize, rest: usize| {
        solved[3 * incidence + rest / 3].reflection[3 * zenith + rest % 3]
    };
    for (one, other) in [(0, 1), (0, 2), (1, 2)] {
        for rest in 0..9 {
            let (forth, back) = (at(one, other, rest), at(other, one, rest));
            // 2³⁰ times the rounding of nodes with a weight of 10⁻¹⁰.
            assert!((forth / back - 1.0).abs() < 1e-6, "{one} {other} {rest}: {forth} {back}");
        }
    }
    let refused = |views: &Views| bidirectional(&stack, views, &options).unwrap_err().to_string();
    assert!(refused(&Views { zeniths_deg: vec![95.0], ..views.clone() }).contains("95"));
    let ice = Stack { layers: vec![Layer::ice(Default::default(), 1.0)], ..stack.clone() };
    assert!(bidirectional(&ice, &views, &options).unwrap_err().to_string().contains("clear ice"));
}
