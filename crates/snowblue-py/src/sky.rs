//! Daylight, and where the sun stands.

use numpy::PyArray1;
use pyo3::prelude::*;
use pyo3::types::PyDict;
use snowblue_sky::{ClearSky, DateTime, Daylight, OvercastSky, Place, Sky};
use snowblue_transport::sunlight::spectral_irradiance;

use crate::work::input;

/// Julian day of midnight of 1 January 1970.
const UNIX_EPOCH: f64 = 2_440_587.5;

/// Elevation, apparent elevation and azimuth of the sun in degrees, and the seconds since 1 January 1970, UTC.
#[pyfunction]
pub(crate) fn sun_position(latitude_deg: f64, longitude_deg: f64, time: &str) -> PyResult<(f64, f64, f64, f64)> {
    let time: DateTime = time.parse().map_err(input)?;
    let sun = snowblue_sky::sun_position(Place { latitude_deg, longitude_deg }, time).map_err(input)?;
    let seconds = 86_400.0 * (time.julian_day().map_err(input)? - UNIX_EPOCH);
    Ok((sun.elevation_deg, sun.apparent_elevation_deg(), sun.azimuth_deg, seconds))
}

/// Irradiance of the standard sun at each wavelength.
#[pyfunction]
pub(crate) fn sunlight(py: Python<'_>, wavelengths_nm: Vec<f64>) -> PyResult<Bound<'_, PyArray1<f64>>> {
    let values = wavelengths_nm.into_iter().map(spectral_irradiance).collect::<Result<Vec<f64>, _>>();
    Ok(PyArray1::from_vec(py, values.map_err(input)?))
}

/// Irradiance of level ground at each wavelength, illuminance and PAR. `haze` is the turbidity and the ground's albedo
/// of a clear sky; without it the sky is overcast.
#[pyfunction]
#[pyo3(signature = (elevation_deg, haze, wavelengths_nm))]
pub(crate) fn sky<'py>(
    py: Python<'py>,
    elevation_deg: f64,
    haze: Option<(f64, f64)>,
    wavelengths_nm: Vec<f64>,
) -> PyResult<Bound<'py, PyDict>> {
    let sky = match haze {
        Some((turbidity, ground_albedo)) => {
            Sky::Clear(ClearSky::new(elevation_deg, turbidity, &[ground_albedo; 11]).map_err(input)?)
        }
        None => Sky::Overcast(OvercastSky::under_sun(elevation_deg).map_err(input)?),
    };
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
