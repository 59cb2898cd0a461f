//! Colours of spectra, snow that matches a colour, and swatches.

use std::path::PathBuf;

use numpy::{PyArray1, PyReadonlyArray1};
use pyo3::prelude::*;
use pyo3::types::PyDict;
use snowblue_color::exposure::{AutoExposure, MAX_STOPS, factor};
use snowblue_color::{Illuminant, Lab, LinearRgb, Srgb8};
use snowblue_database::Interval;
use snowblue_database::matching::{self, Given, Match, Problem, Target};
use snowblue_render::film::image_file::write_raster_png;
use snowblue_render::raster::RasterImage;
use snowblue_transport::optics::Wavelengths;

use crate::arguments::{Angle, Colorimetry, GivenSnow, Ordinates};
use crate::work::{failure, input, run};

/// Names of all illuminants.
#[pyfunction]
pub(crate) fn illuminants() -> Vec<&'static str> {
    Illuminant::all().map(Illuminant::name).collect()
}

/// XYZ, CIELAB, linear sRGB and hex of spectra, one after the other in `values`. Without an exposure in stops the
/// greatest channel of all becomes 0.9 in hex.
#[pyfunction]
#[pyo3(signature = (values, wavelengths_nm, light, exposure))]
pub(crate) fn colors<'py>(
    py: Python<'py>,
    values: PyReadonlyArray1<'py, f64>,
    wavelengths_nm: Vec<f64>,
    light: Colorimetry,
    exposure: Option<f64>,
) -> PyResult<Bound<'py, PyDict>> {
    let colorimeter = light.colorimeter(&wavelengths_nm)?;
    check_finite(values.as_slice()?, exposure)?;
    let xyz: Vec<_> =
        values.as_slice()?.chunks_exact(wavelengths_nm.len()).map(|spectrum| colorimeter.xyz(spectrum)).collect();
    let lab: Vec<_> = xyz.iter().map(|xyz| Lab::from_xyz(*xyz, colorimeter.white())).collect();
    let rgb: Vec<_> = xyz.iter().map(|xyz| LinearRgb::from_xyz(*xyz)).collect();
    let exposed = match exposure {
        Some(stops) => factor(stops),
        None => AutoExposure::OF_COLORS.factor(rgb.iter().copied()),
    };
    let dict = PyDict::new(py);
    let add = |name: &str, values: Vec<[f64; 3]>| dict.set_item(name, PyArray1::from_vec(py, values.concat()));
    add("xyz", xyz.iter().map(|xyz| [xyz.x, xyz.y, xyz.z]).collect())?;
    add("lab", lab.iter().map(|lab| [lab.l, lab.a, lab.b]).collect())?;
    add("rgb_linear", rgb.iter().map(|rgb| [rgb.r, rgb.g, rgb.b]).collect())?;
    dict.set_item("hex", rgb.iter().map(|rgb| (*rgb * exposed).display_hex()).collect::<Vec<_>>())?;
    Ok(dict)
}

fn check_finite(values: &[f64], exposure_stops: Option<f64>) -> PyResult<()> {
    if let Some(value) = values.iter().find(|value| !value.is_finite()) {
        return Err(input(format!("the spectrum has the value {value}, but must be finite")));
    }
    match exposure_stops {
        Some(stops) if !(-MAX_STOPS..=MAX_STOPS).contains(&stops) => {
            Err(input(format!("exposure is {stops} stops, but must lie in -{MAX_STOPS} to {MAX_STOPS} stops")))
        }
        _ => Ok(()),
    }
}

/// Parameters that `match_color` may not change.
#[derive(FromPyObject)]
#[pyo3(from_item_all)]
pub(crate) struct Fixed {
    thickness_cm: Option<(f64, f64)>,
    grain_size: bool,
    density: bool,
}

/// Snow whose transmitted light has the hue and chroma of an sRGB colour: a list of candidates, and how the colour
/// differs from the first if it is out of reach.
#[pyfunction]
#[pyo3(signature = (target, snow, angle, fixed, light, ordinates))]
#[expect(clippy::too_many_arguments, reason = "one for each group of keywords")]
pub(crate) fn match_color<'py>(
    py: Python<'py>,
    target: &str,
    snow: GivenSnow,
    angle: Angle,
    fixed: Fixed,
    light: Colorimetry,
    ordinates: Ordinates,
) -> PyResult<(Vec<Bound<'py, PyDict>>, Option<String>)> {
    let hex: Srgb8 = target.parse().map_err(input)?;
    let Wavelengths(wavelengths_nm) = Wavelengths::visible();
    let colorimeter = light.colorimeter(&wavelengths_nm)?;
    let given = Given {
        thickness_cm: fixed.thickness_cm.map(|(low, high)| Interval { low, high }),
        grain_size: fixed.grain_size,
        density: fixed.density,
    };
    let problem = Problem::new(snow.sample().map_err(input)?, angle.incidence()?, given);
    let options = ordinates.options()?;
    let color = hex.decode().xyz();
    let (found, missed) = run(py, None, move |_| {
        let white = LinearRgb { r: 1.0, g: 1.0, b: 1.0 }.xyz();
        let target = Target { color, white, colorimeter: &colorimeter };
        let found = matching::closest(&target, &problem, &options).map_err(input)?;
        let missed = found.first().filter(|nearest| !nearest.within_reach());
        let missed = missed.map(|nearest| format!("the colour is out of reach: it is {}", nearest.deviation(&target)));
        Ok((found, missed))
    })?;
    let row = |matched: &Match| {
        let dict = PyDict::new(py);
        let shown = |xyz| LinearRgb::from_xyz(xyz).display_hex();
        dict.set_item("grain_size_um", matched.sample.grain_size.middle_um())?;
        dict.set_item("density_kg_m3", matched.sample.density_kg_m3)?;
        dict.set_item("thickness_cm", matched.thickness_cm)?;
        dict.set_item("delta_e", matched.difference.at_middle_grey)?;
        dict.set_item("delta_e_2000", matched.difference.at_middle_grey_2000)?;
        dict.set_item("within_reach", matched.within_reach())?;
        dict.set_item("Y", matched.light.y)?;
        dict.set_item("exposure_stops", (color.y / matched.light.y).log2())?;
        dict.set_item("hex", shown(matched.light.with_luminance(color.y)))?;
        dict.set_item("hex_transmitted", shown(matched.light))?;
        Ok(dict)
    };
    Ok((found.iter().map(row).collect::<PyResult<_>>()?, missed))
}

/// Draws linear sRGB colours as squares, in rows of a number of columns: the bytes of the picture. Without an exposure
/// in stops the greatest channel of all becomes 0.9.
#[pyfunction]
#[pyo3(signature = (colors, columns, size_px, exposure, output))]
#[expect(clippy::too_many_arguments, reason = "one for each of what a picture is made of")]
pub(crate) fn draw_swatches<'py>(
    py: Python<'py>,
    colors: PyReadonlyArray1<'py, f64>,
    columns: usize,
    size_px: u32,
    exposure: Option<f64>,
    output: Option<PathBuf>,
) -> PyResult<Bound<'py, PyArray1<u8>>> {
    check_finite(colors.as_slice()?, exposure)?;
    let colours: Vec<LinearRgb> =
        colors.as_slice()?.as_chunks().0.iter().map(|&[r, g, b]| LinearRgb { r, g, b }).collect();
    let factor = exposure.map_or_else(|| AutoExposure::OF_COLORS.factor(colours.iter().copied()), factor);
    let exposed: Vec<LinearRgb> = colours.iter().map(|colour| *colour * factor).collect();
    let rows: Vec<Vec<LinearRgb>> = exposed.chunks(columns).map(<[LinearRgb]>::to_vec).collect();
    let drawn = RasterImage::patches(&rows, size_px);
    if let Some(path) = output {
        let software = concat!("snowblue ", env!("CARGO_PKG_VERSION"));
        write_raster_png(&drawn, &[("Software", software)], &path).map_err(failure)?;
    }
    Ok(PyArray1::from_vec(py, drawn.bytes()))
}
