//! Daylight, and the position of the sun.

use numpy::PyArray1;
use pyo3::prelude::*;
use pyo3::types::PyDict;
use snowblue_sky::{Clouds, DateTime, Daylight, Place, Weather, times_of_day};
use snowblue_transport::sunlight::spectral_irradiance;

use crate::work::input;

/// Julian day of midnight of 1 January 1970.
const UNIX_EPOCH: f64 = 2_440_587.5;

/// Elevation, apparent elevation and azimuth of the sun in degrees, and the seconds since 1 January 1970, UTC.
#[pyfunction]
pub(crate) fn sun_position(latitude_deg: f64, longitude_deg: f64, time: &str) -> PyResult<(f64, f64, f64, f64)> {
    position(Place { latitude_deg, longitude_deg }, time.parse().map_err(input)?)
}

/// The same at the middles of the quarters of an hour of a date, by the mean solar time of the place.
#[pyfunction]
pub(crate) fn sun_of_day(latitude_deg: f64, longitude_deg: f64, date: &str) -> PyResult<Vec<(f64, f64, f64, f64)>> {
    let place = Place { latitude_deg, longitude_deg };
    let times = times_of_day(date, longitude_deg).map_err(input)?;
    times.into_iter().map(|time| position(place, time)).collect()
}

fn position(place: Place, time: DateTime) -> PyResult<(f64, f64, f64, f64)> {
    let sun = snowblue_sky::sun_position(place, time).map_err(input)?;
    let seconds = 86_400.0 * (time.julian_day().map_err(input)? - UNIX_EPOCH);
    Ok((sun.elevation_deg, sun.apparent_elevation_deg(), sun.azimuth_deg, seconds))
}

/// Wavelengths that sample daylight.
#[pyfunction]
pub(crate) fn daylight_wavelengths() -> Vec<f64> {
    snowblue_sky::daylight_wavelengths_nm()
}

/// Irradiance of the standard sun at each wavelength.
#[pyfunction]
pub(crate) fn sunlight(py: Python<'_>, wavelengths_nm: Vec<f64>) -> PyResult<Bound<'_, PyArray1<f64>>> {
    let values = wavelengths_nm.into_iter().map(spectral_irradiance).collect::<Result<Vec<f64>, _>>();
    Ok(PyArray1::from_vec(py, values.map_err(input)?))
}

/// Irradiance of level ground at each wavelength, illuminance and PAR, of which there is none with the sun below the
/// horizon. The weather is whether clouds cover the sky, their optical thickness or else the turbidity, the albedo of
/// the ground, and the precipitable water in cm.
#[pyfunction]
pub(crate) fn sky<'py>(
    py: Python<'py>,
    elevation_deg: f64,
    weather: (bool, f64, f64, f64),
    wavelengths_nm: Vec<f64>,
) -> PyResult<Bound<'py, PyDict>> {
    let (is_overcast, haze, ground_albedo, precipitable_water_cm) = weather;
    let clouds =
        if is_overcast { Clouds::Overcast { optical_thickness: haze } } else { Clouds::None { turbidity: haze } };
    let weather = Weather { clouds, ground_albedo, precipitable_water_cm };
    let sky = weather.sky(elevation_deg).map_err(input)?;
    let rows = sky.irradiance(&wavelengths_nm).map_err(input)?;
    let dict = PyDict::new(py);
    let add = |name: &str, part: fn(&Daylight) -> f64| {
        dict.set_item(name, PyArray1::from_vec(py, rows.iter().map(part).collect()))
    };
    add("direct_normal", |light| light.direct_normal)?;
    add("direct", |light| light.direct)?;
    add("diffuse", |light| light.diffuse)?;
    add("global", |light| light.global())?;
    for (name, light) in [("illuminance", sky.illuminance()), ("par", sky.par())] {
        dict.set_item(format!("{name}_direct"), light.direct)?;
        dict.set_item(format!("{name}_diffuse"), light.diffuse)?;
    }
    Ok(dict)
}
