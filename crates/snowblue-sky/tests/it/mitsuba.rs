//! Radiances and irradiances that Mitsuba 3.9.1 computes with its own code from the same coefficients, in single
//! precision. `tests/mitsuba_sunsky.py` wrote them; it says how.
use snowblue_sky::{ClearSky, SUN_RADIUS_RAD};

/// The wavelengths of the value columns: one of the model's own, and three between them.
const WAVELENGTHS_NM: [f64; 4] = [400.0, 450.0, 545.0, 700.0];

fn rows<const N: usize>(csv: &str) -> Vec<[f64; N]> {
    let row = |line: &str| {
        let fields: Vec<f64> = line.split(',').map(|field| field.parse().unwrap()).collect();
        fields.try_into().unwrap()
    };
    csv.lines().skip(1).map(row).collect()
}

/// The fixture has six digits, single precision seven, of which the sums and exponentials of the model lose one.
#[test]
fn radiance_of_the_sky() {
    let rows = rows::<9>(include_str!("../data/mitsuba_sky.csv"));
    assert_eq!(rows.len(), 5 * 3 * 200);
    for case in rows.chunks(200) {
        let [turbidity, ground_albedo, elevation_deg, ..] = case[0];
        let sky = ClearSky::new(elevation_deg, turbidity, &[ground_albedo; 11]).unwrap();
        let elevation = elevation_deg.to_radians();
        for [.., zenith_deg, azimuth_deg, l400, l450, l545, l700] in case {
            let (zenith, azimuth) = (zenith_deg.to_radians(), azimuth_deg.to_radians());
            let cos_sun = zenith.cos() * elevation.sin() + zenith.sin() * elevation.cos() * azimuth.cos();
            for (wavelength_nm, expected) in WAVELENGTHS_NM.into_iter().zip([l400, l450, l545, l700]) {
                let radiance = sky.radiance(wavelength_nm, zenith.cos(), cos_sun);
                let at = format!("{turbidity}, {elevation_deg}°, {zenith_deg}°, {azimuth_deg}°, {wavelength_nm} nm");
                assert!((radiance - expected).abs() < 2e-5 * expected, "{at}: {radiance} instead of {expected}");
            }
        }
    }
}

/// The edge of the disc is 0.0047 rad away from its centre, which single precision resolves to 2e-5; the steep limb
/// darkening at 0.8 of the radius, and the steep rise of a low sun's radiance with elevation, multiply that. The
/// irradiances are sums of such radiances over 64 by 32 points, here over 32 by 64.
#[test]
fn radiance_and_irradiance_of_the_sun() {
    let rows = rows::<7>(include_str!("../data/mitsuba_sun.csv"));
    assert_eq!(rows.len(), 5 * 3 * 4);
    for [turbidity, elevation_deg, fraction, values @ ..] in rows {
        let sky = ClearSky::new(elevation_deg, turbidity, &[0.3; 11]).unwrap();
        for (wavelength_nm, expected) in WAVELENGTHS_NM.into_iter().zip(values) {
            let (value, tolerance) = if fraction < 0.0 {
                (sky.sun_irradiance(wavelength_nm), 5e-4)
            } else {
                let angle = fraction * SUN_RADIUS_RAD;
                let cos_zenith = (elevation_deg.to_radians() + angle).sin();
                (sky.sun_radiance(wavelength_nm, cos_zenith, angle.sin()), 2e-4)
            };
            let at = format!("{turbidity}, {elevation_deg}°, {fraction}, {wavelength_nm} nm");
            assert!((value - expected).abs() <= tolerance * expected, "{at}: {value} instead of {expected}");
        }
    }
}
