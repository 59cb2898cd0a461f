//! `snowblue sky`: daylight on the ground, per wavelength.

use clap::Args;
use snowblue_figures::{Cell, DataTable, Metadata};
use snowblue_sky::{DAYLIGHT_RANGE_NM, DateTime, Daylight, Place, Sky as Model, SunPosition, sun_position};
use snowblue_transport::optics::Wavelengths;

use crate::options::WeatherOptions;
use crate::options::parse;
use crate::output::{Failure, Outcome, OutputOptions};

/// Compute the irradiance of level ground by the sun and the sky, per wavelength
#[derive(Debug, Args)]
#[command(
    allow_negative_numbers = true,
    after_help = "Columns: 'direct' is the light of the sun's disc, on a plane that faces it ('normal') and on level \
ground; 'diffuse' is the light of the sky on level ground; 'global' is both, in W/(m² nm). A clear sky is that of \
Hosek & Wilkie (2012, 2013) to 720 nm and of Bird & Riordan (1986) beyond, scaled to agree at 656 nm, an overcast sky \
that of the CIE with the spectrum D65 and the mean illuminance of Krochmann & Seidl (1974) for the sun's elevation; \
beyond 720 nm its spectrum is that of clouds of droplets. \
With the sun below the horizon all light is zero: there is no model of twilight.

Examples:
  snowblue sky --elevation 25 --turbidity 2
  snowblue sky --latitude 47.27 --longitude 11.39 --time 2026-02-01T12:00:00+01:00 -o noon.csv
  snowblue sky --elevation 25 --overcast --wavelengths 450,550,650"
)]
pub(crate) struct Sky {
    #[arg(
        long, value_name = "DEG", value_parser = parse::number, help_heading = "Sun",
        conflicts_with_all = ["latitude", "longitude", "time", "refraction"],
        help = "Angle between the horizon and the sun, in degrees [-90–90]"
    )]
    elevation: Option<f64>,
    /// Latitude in degrees, north positive [-90–90]
    #[arg(
        long, value_name = "DEG", value_parser = parse::number, help_heading = "Sun",
        requires_all = ["longitude", "time"]
    )]
    latitude: Option<f64>,
    /// Longitude in degrees, east positive [-180–180]
    #[arg(long, value_name = "DEG", value_parser = parse::number, help_heading = "Sun", requires = "latitude")]
    longitude: Option<f64>,
    /// Date, time and offset from UTC, as 2026-02-01T12:00:00+01:00 [years 1800–2200]
    #[arg(long, value_name = "TIME", value_parser = parse::time, help_heading = "Sun", requires = "latitude")]
    time: Option<DateTime>,
    /// Use the elevation at which the sun is seen, lifted by the refraction of the air
    #[arg(long, help_heading = "Sun", requires = "latitude")]
    refraction: bool,
    #[command(flatten)]
    weather: WeatherOptions,
    /// Fraction of light that the ground reflects into the sky [0–1]
    #[arg(long, value_name = "A", value_parser = parse::number, default_value = "0.8", help_heading = "Sky")]
    ground_albedo: f64,
    #[arg(
        long, value_name = "NM", default_value = "320:720:10", help_heading = "Sky",
        help = format!(
            "Wavelengths in nm: FIRST:LAST:STEP or a list [{}–{}]", DAYLIGHT_RANGE_NM.0, DAYLIGHT_RANGE_NM.1
        )
    )]
    wavelengths: Wavelengths,
    #[command(flatten)]
    output: OutputOptions,
}

impl Sky {
    pub(crate) fn run(&self, quiet: bool) -> Outcome {
        self.output.check()?;
        let position = self.position()?;
        let elevation_deg = match (self.elevation, position) {
            (Some(elevation_deg), _) => elevation_deg,
            (None, Some(position)) if self.refraction => position.apparent_elevation_deg(),
            (None, Some(position)) => position.elevation_deg,
            (None, None) => {
                return Err(Failure::Input("give --elevation, or --latitude, --longitude and --time".to_owned()));
            }
        };
        let sky = self.weather.weather(self.ground_albedo).sky(elevation_deg).map_err(Failure::input)?;
        let Wavelengths(wavelengths_nm) = &self.wavelengths;
        let rows = sky.irradiance(wavelengths_nm).map_err(Failure::input)?;
        let row = |(wavelength_nm, light): (&f64, &Daylight)| {
            let values = [*wavelength_nm, light.direct_normal, light.direct, light.diffuse, light.global()];
            values.map(Cell::Number).to_vec()
        };
        let columns =
            vec!["wavelength_nm", "direct_normal_w_m2_nm", "direct_w_m2_nm", "diffuse_w_m2_nm", "global_w_m2_nm"];
        let rows = wavelengths_nm.iter().zip(&rows).map(row).collect();
        let metadata = self.metadata(&sky, elevation_deg, position);
        self.output.write(&DataTable { columns, rows, metadata }, quiet)
    }

    /// The position of the sun at the place and time, if they are given.
    fn position(&self) -> Result<Option<SunPosition>, Failure> {
        let (Some(latitude_deg), Some(longitude_deg), Some(time)) = (self.latitude, self.longitude, self.time) else {
            return Ok(None);
        };
        sun_position(Place { latitude_deg, longitude_deg }, time).map(Some).map_err(Failure::input)
    }

    fn metadata(&self, sky: &Model, elevation_deg: f64, position: Option<SunPosition>) -> Metadata {
        let mut metadata: Metadata = vec![("snowblue", env!("CARGO_PKG_VERSION").to_owned())];
        if self.weather.overcast {
            metadata.push(("sky", "overcast".to_owned()));
            metadata.push(("optical thickness of clouds", self.weather.cloud_thickness.to_string()));
        } else {
            metadata.push(("sky", "clear".to_owned()));
            metadata.push(("turbidity", self.weather.turbidity.to_string()));
        }
        metadata.push(("ground albedo", self.ground_albedo.to_string()));
        metadata.push(("precipitable water", format!("{} cm", self.weather.precipitable_water)));
        metadata.push(("sun elevation", format!("{elevation_deg:.2}°")));
        if let Some(position) = position {
            metadata.push(("sun azimuth", format!("{:.2}°", position.azimuth_deg)));
        }
        let parts = |light: Daylight, unit: &str| {
            format!("{:.0} {unit} direct, {:.0} {unit} diffuse", light.direct, light.diffuse)
        };
        metadata.push(("illuminance", parts(sky.illuminance(), "lx")));
        metadata.push(("PAR", parts(sky.par(), "µmol/(m² s)")));
        metadata
    }
}
