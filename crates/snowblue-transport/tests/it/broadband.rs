//! Broadband values of snow in sunlight: against published ones, and with fewer wavelengths.

use snowblue_transport::ordinates::{self, OrdinatesOptions};
use snowblue_transport::sample::{GrainSize, SnowSample};
use snowblue_transport::slab::{Fluxes, Incidence, Radiometry, Slab};
use snowblue_transport::sunlight::{Band, BandWeights, MAX_STEP_NM};

fn steps(first: u32, last: u32, step: usize) -> Vec<f64> {
    (first..=last).step_by(step).map(f64::from).collect()
}

fn curves(sample: SnowSample, thicknesses_cm: &[f64], angles_deg: &[f64], wavelengths_nm: Vec<f64>) -> Vec<Radiometry> {
    let slab = Slab {
        sample,
        thicknesses_cm: thicknesses_cm.to_vec(),
        incidences: angles_deg.iter().map(|angle_deg| Incidence::Beam { angle_deg: *angle_deg }).collect(),
        wavelengths_nm,
    };
    let options = OrdinatesOptions { tally_rays: 1 << 14, ..OrdinatesOptions::default() };
    ordinates::solve_without_errors(&slab, &options).unwrap()
}

fn broadband(band: Band, curve: &[Radiometry]) -> Fluxes {
    let (wavelengths_nm, fluxes): (Vec<f64>, Vec<Fluxes>) =
        curve.iter().map(|row| (row.wavelength_nm, row.fluxes)).unzip();
    BandWeights::new(band, &wavelengths_nm).unwrap().broadband(&fluxes)
}

/// Gardner & Sharp (2010, doi:10.1029/2009JF001444) fit the broadband albedo of deep pure snow by 1.48 − S^−0.07 for
/// the sun at the zenith, with the specific surface area S in cm²/g, and a term for lower suns. They assume Mie spheres
/// and another atmosphere; our albedo is 0.02 lower throughout. The visible albedo of pure snow is 0.96–0.99
/// (Wiscombe & Warren 1980, abstract of part II).
#[test]
fn albedo_of_deep_pure_snow_agrees_with_published_values() {
    let angles_deg: [f64; 2] = [0.0, 60.0];
    for area_m2_kg in [20.0, 60.0, 100.0] {
        let grain_size = GrainSize::from_specific_surface_area(area_m2_kg, -5.0).unwrap();
        let wavelengths_nm = steps(300, 2500, 10);
        let sample = SnowSample { grain_size, ..SnowSample::default() };
        let curves = curves(sample, &[500.0], &angles_deg, wavelengths_nm.clone());
        let zenith = 1.48 - (10.0 * area_m2_kg).powf(-0.07);
        for (curve, angle_deg) in curves.chunks_exact(wavelengths_nm.len()).zip(angles_deg) {
            let lower_sun = (1.0 - angle_deg.to_radians().cos()).powf(1.2);
            let published = zenith + 0.53 * zenith * (1.0 - zenith) * lower_sun;
            let albedo = broadband(Band::Solar, curve).reflectance.value;
            assert!((albedo - published).abs() < 0.03, "{area_m2_kg} m²/kg, {angle_deg}°: {albedo}, not {published}");
            let visible = broadband(Band::Visible, curve).reflectance.value;
            assert!((0.96..0.995).contains(&visible), "{area_m2_kg} m²/kg, {angle_deg}°: {visible}");
        }
    }
}

/// A step of 10 nm, the default of the command, changes the albedo by 2·10⁻⁵, the widest step allowed by 0.003.
#[test]
fn few_wavelengths_suffice() {
    let close = curves(SnowSample::default(), &[1.0, 15.0, 30.0], &[0.0], steps(300, 2500, 5));
    for band in Band::ALL {
        for curve in close.chunks_exact(441) {
            let with_step = |step: usize| {
                let few: Vec<Radiometry> = curve.iter().step_by(step).copied().collect();
                broadband(band, &few)
            };
            let (fine, usual, coarse) = (with_step(1), with_step(2), with_step(10));
            assert!((curve[10].wavelength_nm - curve[0].wavelength_nm - MAX_STEP_NM).abs() < 1e-9);
            assert!((usual.reflectance.value - fine.reflectance.value).abs() < 2e-5, "{usual:?} {fine:?}");
            assert!((coarse.reflectance.value - fine.reflectance.value).abs() < 3e-3, "{coarse:?} {fine:?}");
            let transmittance = |of: &Fluxes| of.transmittance.value;
            assert!((transmittance(&usual) / transmittance(&fine) - 1.0).abs() < 0.012, "{usual:?} {fine:?}");
        }
    }
}
