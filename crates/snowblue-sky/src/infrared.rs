//! Skies beyond the visible, 720–2500 nm.
//!
//! # Clear
//!
//! After Bird & Riordan (1984, SERI/TR-215-2436, doi:10.2172/5986936; 1986, J. Clim. Appl. Meteorol. 25, 87). The
//! sun's light outside the air is weakened by molecules, aerosol, ozone, water vapour and the other gases, each by
//! its own law of the air mass (Kasten 1966). Half of the light that molecules scatter and a part of the light that
//! aerosol scatters arrives as light of the sky. Where the constants of the authors' program `spectrl2_2.c` differ
//! from the report, the constants of the program are used.
//!
//! The optical thickness of the aerosol is β λ^−1.3 with λ in µm. β is chosen such that the irradiance of the sun at
//! 656 nm, where no vapour absorbs, equals its irradiance in the model of Hosek & Wilkie. If the latter exceeds the
//! irradiance without aerosol, β is 0 and the sun is scaled. The diffuse light is scaled to the diffuse light of
//! Hosek & Wilkie at 656 nm. It includes light that the ground reflects and the sky sends back (1986, equations 3-13
//! to 3-15). Over snow this light is a fifth of the diffuse light at 656 nm.
//!
//! # Overcast
//!
//! The sun's light outside the air is weakened by the gases of the clear model, with the path of diffuse light, and
//! by a cloud of droplets ([`Cloud`]). Ground and cloud reflect light to each other. The light is scaled to the light
//! of the overcast sky at 656 nm, so that its spectrum does not depend on the elevation of the sun, as in the
//! visible.
//!
//! # Simplified
//!
//! Between the 75 wavelengths of the table irradiances are linear, so bands of vapour are as in a spectrum of some 10
//! nm. The ground is as bright as snow beyond the visible: its albedo equals the albedo at 720 nm up to 800 nm and
//! falls linearly to 0 at 1500 nm. The sun is at its mean distance, and the place at sea level. The longer paths of
//! light through the vapour inside a cloud are left out, and so are clouds of ice.

use std::sync::LazyLock;

use crate::clear_sky::ClearSky;
use crate::cloud::Cloud;
use crate::overcast::OvercastSky;
use crate::tables::{INFRARED_WAVELENGTHS, NODES, WAVELENGTHS_NM, at_wavelength, shipped};

/// Ozone, in cm at standard conditions, as in ASTM G173-03.
const OZONE_CM: f64 = 0.34;

/// Wavelength at which both models are made equal, in nm: a wavelength of the table without absorption by vapour.
const JOIN_NM: f64 = 656.0;

/// Exponent of the wavelength in the optical thickness of aerosol (Ångström 1929).
const AEROSOL_EXPONENT: f64 = 1.3;

/// Least ratio of the sun's irradiance to its irradiance without aerosol, from which the haze is found.
const MIN_SUN: f64 = 1e-6;

const HEADER: &str = "wavelength_nm,extraterrestrial_w_m2_nm,water_vapour,ozone,mixed_gases";

/// Wavelength, irradiance outside the air, and coefficients of water vapour, ozone and mixed gases.
static TABLE: LazyLock<Vec<[f64; 5]>> =
    LazyLock::new(|| shipped(include_str!("../data/bird_riordan_1986.csv"), HEADER, &[[]; INFRARED_WAVELENGTHS]));

/// Where the albedo of snow begins to fall and where snow is dark, in nm (Wiscombe & Warren 1980, figure 8).
const SNOW_FADES_NM: (f64, f64) = (800.0, 1500.0);

/// Air mass of diffuse light, such as the light that the ground reflects.
const DIFFUSE_MASS: f64 = 1.8;

/// Irradiance by the sun and by the sky.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Irradiance {
    /// Irradiance by the sun of a plane that faces the sun.
    pub(crate) direct_normal: f64,
    /// Irradiance by the sky of level ground.
    pub(crate) diffuse: f64,
}

/// The infrared light of a sky.
pub(crate) struct Infrared {
    /// Irradiances at each wavelength of the table, before scaling. The diffuse irradiance is divided by the sine of
    /// the sun's elevation.
    rows: Vec<(f64, Irradiance)>,
    direct_factor: f64,
    diffuse_factor: f64,
}

impl Infrared {
    /// The infrared light of a clear sky. `diffuse` is the irradiance of level ground at each of [`WAVELENGTHS_NM`].
    pub(crate) fn clear(sky: &ClearSky, diffuse: &[f64; NODES]) -> Self {
        let water_cm = sky.precipitable_water_cm();
        let visible_albedo = |nm: f64| at_wavelength(sky.ground_albedo(), nm.min(WAVELENGTHS_NM[NODES - 1]));
        let with = |beta| {
            let rows = rows(sky.sun_elevation_deg(), beta, water_cm, |nm| ground_albedo(visible_albedo(nm), nm));
            Self { rows, direct_factor: 1.0, diffuse_factor: 1.0 }
        };
        let (sun, clean) = (sky.sun_irradiance(JOIN_NM), with(0.0).at(JOIN_NM).direct_normal);
        // For a sun just above the horizon, the irradiance of the sun is 0 in the model of Hosek & Wilkie.
        let thickness = (clean / sun.max(MIN_SUN * clean)).ln() / air_mass(sky.sun_elevation_deg());
        let mut infrared = with(thickness.max(0.0) * (1e-3 * JOIN_NM).powf(AEROSOL_EXPONENT));
        let at_join = infrared.at(JOIN_NM);
        infrared.direct_factor = sun / at_join.direct_normal;
        infrared.diffuse_factor = at_wavelength(diffuse, JOIN_NM) / at_join.diffuse;
        infrared
    }

    /// The infrared light of an overcast sky.
    pub(crate) fn overcast(sky: &OvercastSky) -> Self {
        let row = |(row, cloud): (&[f64; 5], Cloud)| {
            let [wavelength_nm, outside, ..] = *row;
            let air = Transmittances::new(row, DIFFUSE_MASS, DIFFUSE_MASS, 0.0, sky.precipitable_water_cm());
            let returned = cloud.reflectance * ground_albedo(sky.ground_albedo(), wavelength_nm);
            let diffuse = outside * air.gases * cloud.transmittance / (1.0 - returned);
            (wavelength_nm, Irradiance { direct_normal: 0.0, diffuse })
        };
        let rows = TABLE.iter().zip(Cloud::table(sky.optical_thickness())).map(row).collect();
        let mut infrared = Self { rows, direct_factor: 1.0, diffuse_factor: 1.0 };
        infrared.diffuse_factor = sky.irradiance(JOIN_NM) / infrared.at(JOIN_NM).diffuse;
        infrared
    }

    /// Irradiances at a wavelength, in W m⁻² nm⁻¹, linear between the wavelengths of the table.
    pub(crate) fn at(&self, wavelength_nm: f64) -> Irradiance {
        let above = self.rows.partition_point(|(nm, _)| *nm <= wavelength_nm).clamp(1, self.rows.len() - 1);
        let ((lower_nm, lower), (upper_nm, upper)) = (self.rows[above - 1], self.rows[above]);
        let fraction = (wavelength_nm - lower_nm) / (upper_nm - lower_nm);
        let between = |low: f64, high: f64| low + fraction * (high - low);
        Irradiance {
            direct_normal: self.direct_factor * between(lower.direct_normal, upper.direct_normal),
            diffuse: self.diffuse_factor * between(lower.diffuse, upper.diffuse),
        }
    }
}

/// Albedo of the ground, which is as bright as snow beyond the visible.
fn ground_albedo(visible: f64, wavelength_nm: f64) -> f64 {
    let (first_nm, last_nm) = SNOW_FADES_NM;
    visible * ((last_nm - wavelength_nm) / (last_nm - first_nm)).clamp(0.0, 1.0)
}

/// The air mass of a sun at an elevation (Kasten 1966).
fn air_mass(elevation_deg: f64) -> f64 {
    1.0 / (elevation_deg.to_radians().sin() + 0.15 * (3.885 + elevation_deg).powf(-1.253))
}

/// Transmittances of the air at one wavelength.
struct Transmittances {
    molecules: f64,
    aerosol_scattering: f64,
    aerosol_absorption: f64,
    /// Transmittance of vapour, ozone and mixed gases.
    gases: f64,
}

impl Transmittances {
    /// Transmittances for an air mass, an air mass of ozone, and aerosol with the optical thickness β λ^−1.3.
    fn new(row: &[f64; 5], mass: f64, ozone_mass: f64, beta: f64, water_cm: f64) -> Self {
        let &[wavelength_nm, _, water, ozone, mixed] = row;
        let micrometres = 1e-3 * wavelength_nm;
        let thickness = beta * micrometres.powf(-AEROSOL_EXPONENT);
        let albedo = 0.945 * (-0.095 * (micrometres / 0.4).ln().powi(2)).exp();
        let (vapour, mixed) = (water * water_cm * mass, mixed * mass);
        Self {
            molecules: (-mass / (micrometres.powi(4) * (115.6406 - 1.3366 / micrometres.powi(2)))).exp(),
            aerosol_scattering: (-albedo * thickness * mass).exp(),
            aerosol_absorption: (-(1.0 - albedo) * thickness * mass).exp(),
            gases: (-0.2385 * vapour / (1.0 + 20.07 * vapour).powf(0.45)
                - ozone * OZONE_CM * ozone_mass
                - 1.41 * mixed / (1.0 + 118.3 * mixed).powf(0.45))
            .exp(),
        }
    }
}

/// The fraction of the light scattered by aerosol that is scattered forwards, for the mean cosine 0.65 of the
/// scattering angle.
fn forwards(cosine: f64) -> f64 {
    let log = (1.0_f64 - 0.65).ln();
    let (first, second) =
        (log * (1.459 + log * (0.1595 + log * 0.4129)), log * (0.0783 + log * (-0.3824 - log * 0.5874)));
    1.0 - 0.5 * ((first + second * cosine) * cosine).exp()
}

/// The model at each wavelength of the table, for aerosol with the optical thickness β λ^−1.3. The diffuse irradiance
/// is divided by the sine of the elevation.
fn rows(elevation_deg: f64, beta: f64, water_cm: f64, ground_albedo: impl Fn(f64) -> f64) -> Vec<(f64, Irradiance)> {
    let (cos_zenith, mass) = (elevation_deg.to_radians().sin(), air_mass(elevation_deg));
    let height = 22.0 / 6370.0;
    let ozone_mass = (1.0 + height) / (cos_zenith * cos_zenith + 2.0 * height).sqrt();
    let row = |row: &[f64; 5]| {
        let [wavelength_nm, outside, ..] = *row;
        let sun = Transmittances::new(row, mass, ozone_mass, beta, water_cm);
        let absorbed = sun.gases * sun.aerosol_absorption;
        let direct_normal = outside * absorbed * sun.molecules * sun.aerosol_scattering;
        let scattered = 0.5 * (1.0 - sun.molecules.powf(0.95))
            + sun.molecules.powf(1.5) * (1.0 - sun.aerosol_scattering) * forwards(cos_zenith);
        let diffuse = outside * absorbed * scattered;
        // Light from the ground, of which the sky sends back a part, repeatedly. Ozone is left out here.
        let up = Transmittances::new(row, DIFFUSE_MASS, 0.0, beta, water_cm);
        let sky_albedo = up.gases
            * up.aerosol_absorption
            * (0.5 * (1.0 - up.molecules)
                + (1.0 - forwards(1.0 / DIFFUSE_MASS)) * up.molecules * (1.0 - up.aerosol_scattering));
        let returned = sky_albedo * ground_albedo(wavelength_nm);
        let from_ground = (direct_normal + diffuse) * returned / (1.0 - returned);
        (wavelength_nm, Irradiance { direct_normal, diffuse: diffuse + from_ground })
    };
    TABLE.iter().map(row).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::rings::midpoints;

    /// The radiative transfer of Zender's SWNB2 below a cloud over snow, as ships with SNICAR (Flanner et al. 2021,
    /// Geosci. Model Dev. 14, 7673): means of bands relative to the mean of 640–670 nm, for its mid-latitude winter,
    /// which has 0.85 cm of water (McClatchey et al. 1972).
    #[test]
    fn the_overcast_spectrum_is_that_of_snicar() {
        const BANDS_NM: [(f64, f64); 8] = [
            (720.0, 800.0),
            (800.0, 900.0),
            (900.0, 1000.0),
            (1000.0, 1100.0),
            (1100.0, 1200.0),
            (1200.0, 1300.0),
            (1300.0, 1500.0),
            (1500.0, 1800.0),
        ];
        const MID_LATITUDE_WINTER: [f64; 8] = [0.717, 0.588, 0.314, 0.329, 0.151, 0.167, 0.035, 0.055];
        let sky = OvercastSky::new(10_000.0).unwrap().with_precipitable_water(0.85).unwrap();
        let infrared = Infrared::overcast(&sky);
        let mean = |(first_nm, last_nm): (f64, f64)| {
            let wavelengths_nm = midpoints(first_nm, last_nm, 100);
            wavelengths_nm.map(|nm| infrared.at(nm).diffuse).sum::<f64>() / 100.0
        };
        let red = mean((640.0, 670.0));
        for (band, expected) in BANDS_NM.into_iter().zip(MID_LATITUDE_WINTER) {
            let ratio = mean(band) / red / expected;
            // Our model has other lines of vapour, and leaves out the longer paths inside the cloud.
            assert!((0.88..1.12).contains(&ratio), "{band:?}: {ratio}");
        }
    }

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

    /// pvlib 0.16.1, `spectrum.spectrl2` with `kasten1966`, grounds of the albedos 0 and 0.8, 101300 Pa and 0.34 cm of
    /// ozone, per the factor 0.9996363404654715 of the distance to the sun on the day given.
    #[test]
    fn the_model_is_that_of_pvlib() {
        let cases = [
            (
                (30.0, 3.0, 1.42),
                [
                    (656.0, 0.963_809_339_243_124_2, 0.155_127_237_195_946_48, 0.198_894_830_346_991_62),
                    (880.0, 0.738_745_318_224_458_8, 0.067_837_440_480_949, 0.082_972_147_591_694_8),
                    (1040.0, 0.568_916_508_449_126_1, 0.038_919_862_676_662_2, 0.046_899_623_081_848_68),
                    (1200.0, 0.366_496_466_421_719_8, 0.019_622_722_465_561_845, 0.022_896_155_836_117_28),
                    (1610.0, 0.203_948_455_489_989_7, 0.006_663_164_401_850_476, 0.007_791_177_321_548_18),
                    (2198.0, 0.065_739_018_822_680_46, 0.001_274_724_871_163_008_4, 0.001_487_432_480_881_002),
                ],
            ),
            (
                (5.0, 2.0, 0.3),
                [
                    (656.0, 0.337_786_744_048_792_9, 0.034_546_792_110_567_38, 0.037_912_766_414_628_14),
                    (880.0, 0.462_141_295_160_075_4, 0.019_165_069_233_229_86, 0.020_540_515_403_957_037),
                    (1040.0, 0.404_330_165_892_049_9, 0.011_367_104_257_136_516, 0.012_084_574_601_125_346),
                    (1200.0, 0.278_362_702_248_485_25, 0.005_793_607_307_756_981, 0.006_108_843_689_089_952),
                    (1610.0, 0.153_408_448_292_409_68, 0.001_811_437_423_370_235_5, 0.001_898_639_104_908_838),
                    (2198.0, 0.058_575_830_476_522_34, 0.000_393_337_717_597_106_25, 0.000_412_086_022_712_139),
                ],
            ),
        ];
        for ((elevation_deg, turbidity, water_cm), expected) in cases {
            let over = |albedo: f64| rows(elevation_deg, 0.04608 * turbidity - 0.04586, water_cm, |_| albedo);
            let (black, snow) = (over(0.0), over(0.8));
            for (wavelength_nm, direct_normal, diffuse, diffuse_over_snow) in expected {
                let place = black.iter().position(|(nm, _)| (nm - wavelength_nm).abs() < 1e-9).unwrap();
                let ([(_, black), (_, snow)], distance) = ([black[place], snow[place]], 0.999_636_340_465_471_5);
                let level = distance * elevation_deg.to_radians().sin();
                assert!((distance * black.direct_normal / direct_normal - 1.0).abs() < 1e-12, "{black:?}");
                assert!((level * black.diffuse / diffuse - 1.0).abs() < 1e-12, "{wavelength_nm} {black:?}");
                assert!((level * snow.diffuse / diffuse_over_snow - 1.0).abs() < 1e-12, "{wavelength_nm} {snow:?}");
            }
        }
    }
}
