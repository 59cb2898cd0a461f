//! Position of the sun, after Meeus 1998, *Astronomical Algorithms*, 2nd edition, ISBN 978-0-943396-61-3.
//!
//! The apparent longitude of the sun (chapter 25, the method of low accuracy, within 0.01°), the obliquity of the
//! ecliptic and the sidereal time (chapters 22 and 12) with the main term of the nutation, the horizontal coordinates
//! (equations 13.5 and 13.6), and the parallax (chapter 40, for a spherical Earth).
//!
//! **Simplified.** Universal time replaces the uniform dynamical time. This changes the sun's longitude by 0.001°
//! around the year 2000 and by less than 0.006° in 1800–2200. The place is at sea level.

use crate::error::{SkyError, check};
use crate::time::DateTime;

/// A place on the Earth.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Place {
    /// Geographic latitude in degrees, −90 to 90, north positive.
    pub latitude_deg: f64,
    /// Longitude in degrees, −180 to 180, east positive.
    pub longitude_deg: f64,
}

/// Direction of the sun's centre.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SunPosition {
    /// Angle above the horizon in degrees, without refraction; negative below the horizon.
    pub elevation_deg: f64,
    /// Angle from north in degrees, 0–360, clockwise: 90 in the east.
    pub azimuth_deg: f64,
}

impl SunPosition {
    /// Angle above the horizon at which the sun is seen, in degrees: with the refraction of Sæmundsson 1986 for 10 °C
    /// and 1010 hPa (Meeus 1998, equation 16.4), within 0.001° for elevations above 10° and 0.002° at the horizon.
    /// Other weather changes the refraction by some percent. Below −1°, where the sun is invisible, the refraction is
    /// left out.
    ///
    /// The sun that is seen on the horizon has already set:
    /// ```
    /// # use snowblue_sky::SunPosition;
    /// let sun = SunPosition { elevation_deg: -0.5, azimuth_deg: 270.0 };
    /// assert!(sun.apparent_elevation_deg() > 0.0);
    /// ```
    #[must_use]
    pub fn apparent_elevation_deg(self) -> f64 {
        let elevation_deg = self.elevation_deg;
        if elevation_deg < -1.0 {
            return elevation_deg;
        }
        let refraction_arcmin = 1.02 / (elevation_deg + 10.3 / (elevation_deg + 5.11)).to_radians().tan();
        // The formula is negative at the zenith, by a ten-thousandth of a degree.
        elevation_deg + refraction_arcmin.max(0.0) / 60.0
    }
}

/// The position of the sun at a place and time, within 0.02°.
///
/// In the middle of the Arctic winter the sun stays below the horizon:
/// ```
/// # use snowblue_sky::{Place, sun_position};
/// let longyearbyen = Place { latitude_deg: 78.22, longitude_deg: 15.65 };
/// let noon = "2025-12-21T12:00+01:00".parse()?;
/// assert!(sun_position(longyearbyen, noon)?.elevation_deg < -10.0);
/// # Ok::<(), snowblue_sky::SkyError>(())
/// ```
///
/// # Errors
/// [`SkyError::OutOfRange`] or [`SkyError::NoSuchDay`] if a part of the place or the time lies outside its range.
pub fn sun_position(place: Place, time: DateTime) -> Result<SunPosition, SkyError> {
    check("latitude", place.latitude_deg, (-90.0, 90.0), "°")?;
    check("longitude", place.longitude_deg, (-180.0, 180.0), "°")?;
    let days = time.julian_day()? - 2_451_545.0;
    let Equatorial { right_ascension, declination, nutation_of_time } = equatorial(days / 36_525.0);
    let sidereal_deg = 280.460_618_37 + 360.985_647_366_29 * days + place.longitude_deg;
    let hour_angle = sidereal_deg.to_radians() + nutation_of_time - right_ascension;
    let latitude = place.latitude_deg.to_radians();

    let sine = latitude.sin() * declination.sin() + latitude.cos() * declination.cos() * hour_angle.cos();
    let south = hour_angle.cos() * latitude.sin() * declination.cos() - declination.sin() * latitude.cos();
    let west = hour_angle.sin() * declination.cos();
    let elevation = sine.atan2(south.hypot(west));
    let azimuth = west.atan2(south).to_degrees() + 180.0;

    /// The Earth's radius at the distance of the sun.
    const PARALLAX_DEG: f64 = 8.794 / 3600.0;
    Ok(SunPosition {
        elevation_deg: elevation.to_degrees() - PARALLAX_DEG * elevation.cos(),
        azimuth_deg: azimuth.rem_euclid(360.0),
    })
}

/// Position of the sun's centre on the sky, seen from the Earth's centre, in radians.
#[derive(Debug, Clone, Copy)]
struct Equatorial {
    right_ascension: f64,
    declination: f64,
    /// Apparent minus mean sidereal time.
    nutation_of_time: f64,
}

/// The sun `t` Julian centuries after noon of 1 January 2000 (Meeus 1998, pages 163–165).
fn equatorial(t: f64) -> Equatorial {
    let mean_longitude_deg = 280.466_46 + t * (36_000.769_83 + t * 0.000_303_2);
    let anomaly = (357.529_11 + t * (35_999.050_29 - t * 0.000_153_7)).to_radians();
    let centre_deg = (1.914_602 - t * (0.004_817 + t * 0.000_014)) * anomaly.sin()
        + (0.019_993 - t * 0.000_101) * (2.0 * anomaly).sin()
        + 0.000_289 * (3.0 * anomaly).sin();
    let node = (125.04 - 1934.136 * t).to_radians();
    let nutation_deg = -0.004_78 * node.sin();
    // 0.00569° is the aberration.
    let longitude = (mean_longitude_deg + centre_deg - 0.005_69 + nutation_deg).to_radians();
    let obliquity = (23.439_291_1 - 0.013_004_2 * t + 0.002_56 * node.cos()).to_radians();
    Equatorial {
        right_ascension: (obliquity.cos() * longitude.sin()).atan2(longitude.cos()),
        declination: (obliquity.sin() * longitude.sin()).asin(),
        nutation_of_time: nutation_deg.to_radians() * obliquity.cos(),
    }
}

#[cfg(test)]
#[expect(clippy::float_cmp, reason = "no refraction")]
mod tests {
    use super::*;

    fn position(latitude_deg: f64, longitude_deg: f64, time: &str) -> SunPosition {
        sun_position(Place { latitude_deg, longitude_deg }, time.parse().unwrap()).unwrap()
    }

    /// Meeus 1998, example 25.a: 1992 October 13, 0 h, apparent right ascension 198.38083° and declination −7.78507°.
    #[test]
    fn example_25_a_of_meeus() {
        let Equatorial { right_ascension, declination, .. } = equatorial((2_448_908.5 - 2_451_545.0) / 36_525.0);
        assert!((right_ascension.to_degrees() + 360.0 - 198.380_83).abs() < 1e-4);
        assert!((declination.to_degrees() + 7.785_07).abs() < 1e-4);
    }

    /// Reda & Andreas 2004, doi:10.1016/j.solener.2003.12.003, appendix A.5: topocentric zenith 50.11162° with a
    /// refraction at 820 hPa and 11 °C, azimuth 194.34024°, and e₀ = 39.872046° before the refraction. The uncertainty
    /// of the method used here is 0.02°.
    #[test]
    fn example_of_the_solar_position_algorithm() {
        let sun = position(39.742_476, -105.178_6, "2003-10-17T12:30:30-07:00");
        assert!((sun.elevation_deg - 39.872_046).abs() < 0.01, "{sun:?}");
        assert!((sun.azimuth_deg - 194.340_24).abs() < 0.015, "{sun:?}");
        // The refraction of Reda & Andreas, scaled to the pressure and temperature of the formula.
        let refraction_deg = (90.0 - 50.111_62 - 39.872_046) / (820.0 / 1010.0 * 283.0 / 284.15);
        assert!((sun.apparent_elevation_deg() - sun.elevation_deg - refraction_deg).abs() < 1e-4);
    }

    #[test]
    fn the_sun_moves_from_east_to_west() {
        let morning = position(47.0, 11.0, "2026-03-20T07:00+01:00");
        let evening = position(47.0, 11.0, "2026-03-20T18:00+01:00");
        assert!((90.0..110.0).contains(&morning.azimuth_deg) && morning.elevation_deg > 0.0, "{morning:?}");
        assert!((250.0..270.0).contains(&evening.azimuth_deg) && evening.elevation_deg > 0.0, "{evening:?}");
        // South of the tropics the sun stands in the north at noon.
        let noon = position(-75.1, 123.3, "2025-12-21T11:45+08:00").azimuth_deg;
        assert!(noon.min(360.0 - noon) < 5.0, "{noon}");
        // At the pole the elevation is the declination: 23.44° at the solstice, less 0.002° of parallax.
        assert!((position(90.0, 0.0, "2025-06-21T02:42Z").elevation_deg - 23.435).abs() < 0.01);
    }

    /// Meeus 1998, page 106: about 0.57° (34') at the horizon where the light is seen at 0°, and 9.9' at 5°.
    #[test]
    fn refraction_lifts_the_sun() {
        let lifted =
            |elevation_deg| SunPosition { elevation_deg, azimuth_deg: 0.0 }.apparent_elevation_deg() - elevation_deg;
        assert!((lifted(-0.57) - 0.57).abs() < 0.01, "{}", lifted(-0.57));
        assert!((lifted(4.835) - 9.9 / 60.0).abs() < 0.003, "{}", lifted(4.835));
        assert!(lifted(90.0) < 1e-4 && lifted(90.0) >= 0.0);
        assert_eq!(lifted(-2.0), 0.0);
    }

    #[test]
    fn bad_places_are_refused_in_one_line() {
        let message = |latitude_deg, longitude_deg| {
            let place = Place { latitude_deg, longitude_deg };
            sun_position(place, "2026-02-01T12:00Z".parse().unwrap()).unwrap_err().to_string()
        };
        assert_eq!(message(91.0, 0.0), "latitude is 91°, but must lie in -90–90°");
        assert_eq!(message(0.0, 181.0), "longitude is 181°, but must lie in -180–180°");
        assert_eq!(message(f64::NAN, 0.0), "latitude is NaN°, but must lie in -90–90°");
    }
}
