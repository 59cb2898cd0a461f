//! `spectrum --sky`: light at depth under the sun and the sky.

use clap::Args;
use snowblue_figures::{Cell, DataTable, Metadata};
use snowblue_sky::{DateTime, Daylight, Place, SkyError, sun_position, times_of_day};
use snowblue_transport::illumination::{Illumination, LightInLayers, LightLevel, light_in_layers};
use snowblue_transport::ordinates::OrdinatesOptions;
use snowblue_transport::stack::Stack;
use snowblue_transport::sunlight::Band;

use super::broadband::{self, Bands};
use crate::options::WeatherOptions;
use crate::options::parse;
use crate::output::Failure;

/// The sun and the sky above the snow.
#[derive(Debug, Args)]
#[command(next_help_heading = "Sky")]
pub(super) struct SkyOptions {
    /// Light at --depths under the sun and the sky, in W/m² per nm, or with --broadband in bands: the sun's ELEVATION
    /// in degrees, or LATITUDE,LONGITUDE,TIME as 47.27,11.39,2026-02-01T12:00+01:00; with a date alone the sums of the
    /// day. Fluxes down, up and net are per level area, actinic fluxes count light from all directions alike, and what
    /// is absorbed is per volume. With the sun below the horizon all light is zero
    #[arg(
        long, value_name = "SUN", value_parser = sun, requires = "depths", allow_hyphen_values = true,
        conflicts_with_all = ["plot", "batch"]
    )]
    sky: Option<Sun>,
    #[command(flatten)]
    weather: WeatherOptions,
    /// Fraction of light that the snow around reflects into the sky [0–1]
    #[arg(long, value_name = "A", value_parser = parse::number, default_value = "0.8", requires = "sky")]
    sky_albedo: f64,
}

/// Where the sun stands.
#[derive(Debug, Clone, PartialEq)]
enum Sun {
    Elevation(f64),
    At(Place, DateTime),
    /// All day.
    Day(Place, String),
}

/// Light at depths, solved.
struct Solved {
    light: LightInLayers,
    stack: Stack,
    is_day: bool,
}

fn sun(words: &str) -> Result<Sun, String> {
    let parts: Vec<&str> = words.split(',').map(str::trim).collect();
    match parts[..] {
        [elevation] => parse::number(elevation).map(Sun::Elevation),
        [latitude, longitude, time] => {
            let place = Place { latitude_deg: parse::number(latitude)?, longitude_deg: parse::number(longitude)? };
            if time.len() == 10 {
                return Ok(Sun::Day(place, time.to_owned()));
            }
            parse::time(time).map(|time| Sun::At(place, time))
        }
        _ => Err("give ELEVATION, or LATITUDE,LONGITUDE,TIME as 47.27,11.39,2026-02-01T12:00+01:00".to_owned()),
    }
}

impl SkyOptions {
    /// Whether there is a sky.
    pub(super) fn is_used(&self) -> bool {
        self.sky.is_some()
    }

    /// The light at the depths of a stack: spectra, or bands.
    pub(super) fn results(
        &self,
        stack: Stack,
        bands: Option<&Bands>,
        options: &OrdinatesOptions,
        metadata: Metadata,
    ) -> Result<DataTable, Failure> {
        let Some(sun) = &self.sky else { return Err(Failure::Work("there is no sky".to_owned())) };
        let elevations_deg = elevations(sun).map_err(Failure::input)?;
        let lights: Result<Vec<_>, _> = elevations_deg
            .iter()
            .map(|elevation_deg| self.illumination(*elevation_deg, &stack.wavelengths_nm))
            .collect();
        let lights = lights.map_err(Failure::input)?;
        let mut solved = light_in_layers(&stack, &lights, options).map_err(Failure::input)?;
        let is_day = matches!(sun, Sun::Day(..));
        let light = if is_day { LightInLayers::sum_of_day(&solved) } else { solved.swap_remove(0) };
        let solved = Solved { light, stack, is_day };
        let mut metadata = metadata;
        metadata.extend(self.metadata(sun, &elevations_deg));
        Ok(match bands {
            None => solved.spectra(metadata),
            Some(bands) => solved.bands(bands.list(), metadata)?,
        })
    }

    fn illumination(&self, elevation_deg: f64, wavelengths_nm: &[f64]) -> Result<Illumination, SkyError> {
        let daylight = self.weather.weather(self.sky_albedo).sky(elevation_deg)?.irradiance(wavelengths_nm)?;
        let part = |of: fn(&Daylight) -> f64| daylight.iter().map(of).collect();
        Ok(Illumination::under_sun(elevation_deg, part(|light| light.direct), part(|light| light.diffuse)))
    }

    fn metadata(&self, sun: &Sun, elevations_deg: &[f64]) -> Metadata {
        let mut metadata = Metadata::new();
        let Self { sky_albedo, weather, .. } = self;
        let WeatherOptions { turbidity, precipitable_water, overcast, cloud_thickness } = weather;
        let sky = if *overcast {
            format!("overcast, optical thickness {cloud_thickness}")
        } else {
            format!("clear, turbidity {turbidity}")
        };
        metadata.push(("sky", format!("{sky}, albedo {sky_albedo}, precipitable water {precipitable_water} cm")));
        match sun {
            Sun::Day(Place { latitude_deg, longitude_deg }, date) => {
                metadata.push(("sum", format!("of {date} at {latitude_deg}°, {longitude_deg}°")));
            }
            _ => metadata.push(("sun elevation", format!("{:.2}°", elevations_deg[0]))),
        }
        metadata
    }
}

/// Elevations of the sun: one elevation, or the elevations of a day.
fn elevations(sun: &Sun) -> Result<Vec<f64>, SkyError> {
    let at = |place: &Place, time| sun_position(*place, time).map(|sun| sun.elevation_deg);
    match sun {
        Sun::Elevation(elevation_deg) => Ok(vec![*elevation_deg]),
        Sun::At(place, time) => Ok(vec![at(place, *time)?]),
        Sun::Day(place, date) => {
            times_of_day(date, place.longitude_deg)?.into_iter().map(|time| at(place, time)).collect()
        }
    }
}

impl Solved {
    /// A row for each depth and wavelength.
    fn spectra(&self, metadata: Metadata) -> DataTable {
        let columns = if self.is_day {
            ["down_j_m2_nm", "up_j_m2_nm", "net_j_m2_nm", "actinic_j_m2_nm", "absorbed_j_m3_nm"]
        } else {
            ["down_w_m2_nm", "up_w_m2_nm", "net_w_m2_nm", "actinic_w_m2_nm", "absorbed_w_m3_nm"]
        };
        let Stack { depths_cm, wavelengths_nm, .. } = &self.stack;
        let places = depths_cm.iter().flat_map(|depth_cm| wavelengths_nm.iter().map(move |nm| [*depth_cm, *nm]));
        let row =
            |(place, level): ([f64; 2], &LightLevel)| place.into_iter().chain(level.values()).map(Cell::from).collect();
        let rows = places.zip(&self.light.levels).map(row).collect();
        DataTable { columns: [&["depth_cm", "wavelength_nm"][..], &columns].concat(), rows, metadata }
    }

    /// A row for each depth and band, then for each layer and band.
    fn bands(&self, bands: &[Band], metadata: Metadata) -> Result<DataTable, Failure> {
        let Self { light, stack, is_day } = self;
        let warming_column = if *is_day { "warming_k" } else { "warming_k_h" };
        let columns = vec![
            "depth_cm",
            "bottom_cm",
            "band",
            "unit",
            "down_per_m2",
            "up_per_m2",
            "net_per_m2",
            "actinic_per_m2",
            "absorbed_per_m2",
            "absorbed_per_m3",
            warming_column,
        ];
        let none = || Cell::word("");
        let mut rows: Vec<Vec<Cell>> = Vec::new();
        for band in bands {
            let of_band = light.band(*band, &stack.wavelengths_nm).map_err(Failure::input)?;
            let name = broadband::name(*band);
            let unit = match (band, is_day) {
                (Band::Par, false) => "µmol/s",
                (Band::Par, true) => "µmol",
                (_, false) => "W",
                (_, true) => "J",
            };
            // For a day, the absorbed energy is in J. Its warming in K is the warming by a power of as many W in a
            // second.
            let warming = |k_h: f64| {
                let value = if *is_day { k_h / 3600.0 } else { k_h };
                if *band == Band::Solar && !value.is_nan() { Cell::from(value) } else { none() }
            };
            let [at_depths, of_layers] = of_band.warming_k_h(stack);
            let named = |from: Cell, to: Cell| vec![from, to, Cell::word(&name), Cell::word(unit)];
            for ((level, depth_cm), k_h) in of_band.levels.iter().zip(&stack.depths_cm).zip(at_depths) {
                let LightLevel { down, up, net, actinic, absorbed_per_m } = *level;
                let mut row = named(Cell::from(*depth_cm), none());
                row.extend([down, up, net, actinic].map(Cell::from));
                row.extend([none(), absorbed_per_m.into(), warming(k_h)]);
                rows.push(row);
            }
            let mut top_cm = 0.0;
            let powers = of_band.absorbed_per_m_of_layers(stack);
            let layers = of_band.absorbed.iter().zip(powers).zip(&stack.layers).zip(of_layers);
            for (((absorbed, power), layer), k_h) in layers {
                let bottom_cm = top_cm + layer.thickness_cm;
                let mut row = named(Cell::from(top_cm), Cell::from(bottom_cm));
                row.extend([none(), none(), none(), none(), Cell::from(*absorbed)]);
                row.extend([if power.is_nan() { none() } else { power.into() }, warming(k_h)]);
                rows.push(row);
                top_cm = bottom_cm;
            }
        }
        Ok(DataTable { columns, rows, metadata })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_sun_is_an_elevation_a_moment_or_a_day() {
        assert_eq!(sun("-5"), Ok(Sun::Elevation(-5.0)));
        let place = Place { latitude_deg: -47.0, longitude_deg: 11.0 };
        assert_eq!(sun("-47,11,2026-02-01"), Ok(Sun::Day(place, "2026-02-01".to_owned())));
        assert!(matches!(sun("-47, 11, 2026-02-01T12:00Z"), Ok(Sun::At(..))));
        assert!(sun("47,11").unwrap_err().starts_with("give ELEVATION"));
        assert!(sun("47,11,noon").is_err() && sun("high").is_err());
    }
}
