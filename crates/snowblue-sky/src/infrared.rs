//! The clear sky beyond the model of Hosek & Wilkie, 720–2500 nm, after Bird & Riordan (1984, SERI/TR-215-2436,
//! doi:10.2172/5986936; 1986, J. Clim. Appl. Meteorol. 25, 87).
//!
//! The sun's light outside the air is weakened by molecules, aerosol, ozone, water vapour and the other gases, each by
//! its own law of the air mass (Kasten 1966); half of what molecules scatter and a part of what aerosol scatters
//! arrives as light of the sky. Constants are those of the authors' program `spectrl2_2.c`, where they differ from the
//! report.
//!
//! The optical thickness of the aerosol is β λ^−1.3 with λ in µm. β is that with which the sun is as bright at 656 nm,
//! where no vapour absorbs, as in the model of Hosek & Wilkie; where that is brighter than without aerosol, β is 0 and
//! the sun is scaled. The diffuse light is scaled to that of Hosek & Wilkie at 656 nm.
//!
//! **Simplified.** Between the 75 wavelengths of the table irradiances are linear, so bands of vapour are as in a
//! spectrum of some 10 nm. The light that the ground sends into the sky and the sky back is left out: a few per cent of
//! the diffuse light.

use std::sync::LazyLock;

use crate::clear_sky::ClearSky;
use crate::tables::{WAVELENGTHS_NM, at_wavelength};

/// Ozone, in cm at standard conditions, as in ASTM G173-03.
const OZONE_CM: f64 = 0.34;

/// Where both models are made equal, in nm: a wavelength of the table, without vapour.
const JOIN_NM: f64 = 656.0;

/// Exponent of the wavelength in the optical thickness of aerosol (Ångström 1929).
const AEROSOL_EXPONENT: f64 = 1.3;

const HEADER: &str = "wavelength_nm,extraterrestrial_w_m2_nm,water_vapour,ozone,mixed_gases";

/// Wavelength, irradiance outside the air, and coefficients of water vapour, ozone and mixed gases.
static TABLE: LazyLock<Vec<[f64; 5]>> = LazyLock::new(|| {
    let mut lines = include_str!("../data/bird_riordan_1986.csv").lines();
    assert_eq!(lines.next(), Some(HEADER), "a table that ships with this crate");
    let row = |line: &str| {
        let mut row = [f64::NAN; 5];
        row.iter_mut().zip(line.split(',')).for_each(|(value, word)| *value = word.parse().unwrap_or(f64::NAN));
        row
    };
    lines.map(row).collect()
});

/// Irradiance by the sun and by the sky.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Light {
    /// Of a plane that faces the sun.
    pub(crate) direct_normal: f64,
    /// Of level ground.
    pub(crate) diffuse: f64,
}

/// The infrared light of a sky.
pub(crate) struct Infrared {
    /// At each wavelength of the table, before scaling.
    rows: Vec<(f64, Light)>,
    direct_factor: f64,
    diffuse_factor: f64,
}

impl Infrared {
    /// That of a sky, of which `diffuse` is the irradiance of level ground at each of [`WAVELENGTHS_NM`].
    pub(crate) fn new(sky: &ClearSky, diffuse: &[f64; WAVELENGTHS_NM.len()]) -> Self {
        let water_cm = sky.precipitable_water_cm();
        let with = |beta| {
            let rows = rows(sky.sun_elevation_deg(), beta, water_cm);
            Self { rows, direct_factor: 1.0, diffuse_factor: 1.0 }
        };
        let (sun, clean) = (sky.sun_irradiance(JOIN_NM), with(0.0).at(JOIN_NM).direct_normal);
        let thickness = (clean / sun).ln() / air_mass(sky.sun_elevation_deg());
        let mut infrared = with(thickness.max(0.0) * (1e-3 * JOIN_NM).powf(AEROSOL_EXPONENT));
        let at_join = infrared.at(JOIN_NM);
        infrared.direct_factor = sun / at_join.direct_normal;
        infrared.diffuse_factor = at_wavelength(diffuse, JOIN_NM) / at_join.diffuse;
        infrared
    }

    /// Irradiances at a wavelength, in W m⁻² nm⁻¹, linear between the wavelengths of the table.
    pub(crate) fn at(&self, wavelength_nm: f64) -> Light {
        let above = self.rows.partition_point(|(nm, _)| *nm <= wavelength_nm).clamp(1, self.rows.len() - 1);
        let ((lower_nm, lower), (upper_nm, upper)) = (self.rows[above - 1], self.rows[above]);
        let fraction = (wavelength_nm - lower_nm) / (upper_nm - lower_nm);
        let between = |low: f64, high: f64| low + fraction * (high - low);
        Light {
            direct_normal: self.direct_factor * between(lower.direct_normal, upper.direct_normal),
            diffuse: self.diffuse_factor * between(lower.diffuse, upper.diffuse),
        }
    }
}

/// The air mass of a sun at an elevation (Kasten 1966).
fn air_mass(elevation_deg: f64) -> f64 {
    1.0 / (elevation_deg.to_radians().sin() + 0.15 * (3.885 + elevation_deg).powf(-1.253))
}

/// The model at each wavelength of the table, for aerosol with the optical thickness β λ^−1.3.
fn rows(elevation_deg: f64, beta: f64, water_cm: f64) -> Vec<(f64, Light)> {
    let (cos_zenith, mass) = (elevation_deg.to_radians().sin(), air_mass(elevation_deg));
    let height = 22.0 / 6370.0;
    let ozone_mass = (1.0 + height) / (cos_zenith * cos_zenith + 2.0 * height).sqrt();
    // The part of the light scattered by aerosol that goes down, for the mean cosine 0.65 of the scattering angle.
    let log = (1.0_f64 - 0.65).ln();
    let (first, second) =
        (log * (1.459 + log * (0.1595 + log * 0.4129)), log * (0.0783 + log * (-0.3824 - log * 0.5874)));
    let downwards = 1.0 - 0.5 * ((first + second * cos_zenith) * cos_zenith).exp();
    let row = |&[wavelength_nm, outside, water, ozone, mixed]: &[f64; 5]| {
        let micrometres = 1e-3 * wavelength_nm;
        let molecules = (-mass / (micrometres.powi(4) * (115.6406 - 1.3366 / micrometres.powi(2)))).exp();
        let thickness = beta * micrometres.powf(-AEROSOL_EXPONENT);
        let albedo = 0.945 * (-0.095 * (micrometres / 0.4).ln().powi(2)).exp();
        let vapour = water * water_cm * mass;
        let gases = mixed * mass;
        let absorbed = (-0.2385 * vapour / (1.0 + 20.07 * vapour).powf(0.45)
            - ozone * OZONE_CM * ozone_mass
            - 1.41 * gases / (1.0 + 118.3 * gases).powf(0.45))
        .exp();
        let direct_normal = outside * absorbed * molecules * (-thickness * mass).exp();
        let scattered = 0.5 * (1.0 - molecules.powf(0.95))
            + molecules.powf(1.5) * (1.0 - (-albedo * thickness * mass).exp()) * downwards;
        let level = outside * cos_zenith * absorbed * (-(1.0 - albedo) * thickness * mass).exp();
        (wavelength_nm, Light { direct_normal, diffuse: level * scattered })
    };
    TABLE.iter().map(row).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_table_is_that_in_print() {
        assert_eq!(TABLE.len(), 75);
        assert!(TABLE.is_sorted_by(|a, b| a[0] < b[0]) && TABLE.iter().flatten().all(|value| value.is_finite()));
        for row in [
            [610.0, 1.728, 0.0, 0.12, 0.0],
            [1040.0, 0.6881, 1e-5, 0.0, 0.0],
            [1395.0, 0.3589, 1000.0, 0.0, 1e-5],
            [2500.0, 0.0485, 310.0, 0.0, 0.000_14],
        ] {
            assert!(TABLE.contains(&row), "{row:?}");
        }
    }

    /// pvlib 0.16.1, `spectrum.spectrl2` with `kasten1966`, black ground, 101300 Pa and 0.34 cm of ozone, per the
    /// factor 0.9996363404654715 of the distance to the sun on the day given.
    #[test]
    fn the_model_is_that_of_pvlib() {
        let cases = [
            (
                (30.0, 3.0, 1.42),
                [
                    (656.0, 0.963_809_339_243_124_2, 0.155_127_237_195_946_48),
                    (880.0, 0.738_745_318_224_458_8, 0.067_837_440_480_949),
                    (1040.0, 0.568_916_508_449_126_1, 0.038_919_862_676_662_2),
                    (1200.0, 0.366_496_466_421_719_8, 0.019_622_722_465_561_845),
                    (1610.0, 0.203_948_455_489_989_7, 0.006_663_164_401_850_476),
                    (2198.0, 0.065_739_018_822_680_46, 0.001_274_724_871_163_008_4),
                ],
            ),
            (
                (5.0, 2.0, 0.3),
                [
                    (656.0, 0.337_786_744_048_792_9, 0.034_546_792_110_567_38),
                    (880.0, 0.462_141_295_160_075_4, 0.019_165_069_233_229_86),
                    (1040.0, 0.404_330_165_892_049_9, 0.011_367_104_257_136_516),
                    (1200.0, 0.278_362_702_248_485_25, 0.005_793_607_307_756_981),
                    (1610.0, 0.153_408_448_292_409_68, 0.001_811_437_423_370_235_5),
                    (2198.0, 0.058_575_830_476_522_34, 0.000_393_337_717_597_106_25),
                ],
            ),
        ];
        for ((elevation_deg, turbidity, water_cm), expected) in cases {
            let rows = rows(elevation_deg, 0.04608 * turbidity - 0.04586, water_cm);
            for (wavelength_nm, direct_normal, diffuse) in expected {
                let (_, light) = rows.iter().find(|(nm, _)| (nm - wavelength_nm).abs() < 1e-9).unwrap();
                let distance = 0.999_636_340_465_471_5;
                assert!((distance * light.direct_normal / direct_normal - 1.0).abs() < 1e-12, "{light:?}");
                assert!((distance * light.diffuse / diffuse - 1.0).abs() < 1e-12, "{wavelength_nm} {light:?}");
            }
        }
    }
}
