//! The coefficients of Hosek & Wilkie, as they ship in `data/`.

use std::sync::LazyLock;

use crate::error::SkyError;

/// The wavelengths of the tables, in nm.
pub const WAVELENGTHS_NM: [f64; NODES] = [320.0, 360.0, 400.0, 440.0, 480.0, 520.0, 560.0, 600.0, 640.0, 680.0, 720.0];

/// Number of wavelengths of the tables.
pub(crate) const NODES: usize = 11;

/// Number of wavelengths of the tables of the air and of clouds, 610–2600 nm.
pub(crate) const INFRARED_WAVELENGTHS: usize = 75;

/// The first and the last turbidity of the tables, which have every whole number in between.
pub const TURBIDITY_RANGE: (f64, f64) = (1.0, 10.0);

/// Water vapour in the air above the ground, in cm of water: 1.42 in the US Standard Atmosphere, 0.1–1 above winter
/// snow.
pub const PRECIPITABLE_WATER_RANGE_CM: (f64, f64) = (0.0, 10.0);

/// Water vapour of the US Standard Atmosphere, in cm of water, as in ASTM G173-03.
pub const PRECIPITABLE_WATER_CM: f64 = 1.42;

/// Control points of the Bézier curves in the elevation of the sun.
pub(crate) const CONTROL_POINTS: usize = 6;

/// Segments of the polynomials of the sun's radiance.
pub(crate) const SEGMENTS: usize = 45;

/// Numbers of a row of the table of the sky: a radiance in W m⁻² sr⁻¹ nm⁻¹, then p0–p8.
pub(crate) const SKY_VALUES: usize = 10;

/// The headers of the two tables of [`Coefficients`].
const SKY_HEADER: &str = "turbidity,ground_albedo,control_point,wavelength_nm,radiance,p0,p1,p2,p3,p4,p5,p6,p7,p8";
const SUN_HEADER: &str = "turbidity,segment,wavelength_nm,c0,c1,c2,c3";

/// The coefficients of the clear sky and the sun, for all elevations, turbidities and grounds.
#[derive(Debug, Clone, PartialEq)]
pub struct Coefficients {
    sky: Vec<[f64; SKY_VALUES]>,
    sun: Vec<[f64; 4]>,
}

static LIMB_DARKENING: LazyLock<[[f64; 6]; NODES]> = LazyLock::new(|| {
    let csv = include_str!("../data/hosek_wilkie_2013_limb_darkening.csv");
    let rows: Vec<[f64; 6]> =
        shipped(csv, "wavelength_nm,a0,a1,a2,a3,a4,a5", &wavelengths().map(|nm| [nm]).collect::<Vec<_>>());
    std::array::from_fn(|node| rows[node])
});

/// The position of a turbidity between the two nearest turbidities of the tables.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct TurbidityLevel {
    /// Index of the lower turbidity, at most 8.
    below: usize,
    /// 0 at the lower turbidity, 1 at the next turbidity above it.
    fraction: f64,
}

impl TurbidityLevel {
    /// The position of a turbidity of [`TURBIDITY_RANGE`].
    pub(crate) fn new(turbidity: f64) -> Self {
        let lower = turbidity.floor().min(TURBIDITY_RANGE.1 - 1.0);
        #[expect(clippy::cast_possible_truncation, reason = "a whole number from 1 to 9")]
        let below = lower as usize - 1;
        Self { below, fraction: turbidity - lower }
    }

    /// Interpolates linearly between the values of the two turbidities, by their index.
    fn interpolate<const N: usize>(self, values: impl Fn(usize) -> [f64; N]) -> [f64; N] {
        between(&values(self.below), &values(self.below + 1), self.fraction)
    }
}

impl Coefficients {
    /// The names of the files of the sky and of the sun in `data/`, which [`parse`](Self::parse) reads.
    pub const FILES: [&str; 2] = ["hosek_wilkie_2012_spectral.csv", "hosek_wilkie_2013_sun.csv"];

    /// Reads the contents of the two [`FILES`](Self::FILES), for a program that does not embed them.
    ///
    /// # Errors
    /// [`SkyError::Coefficients`] if the header, the number of lines, the keys of a line or its number of values
    /// differ from the file that ships with this crate.
    pub fn parse(sky_csv: &str, sun_csv: &str) -> Result<Self, SkyError> {
        let [sky_file, sun_file] = Self::FILES;
        let wrong = |file: &'static str| move |reason: String| SkyError::Coefficients { file, reason };
        Ok(Self {
            sky: parse(sky_csv, SKY_HEADER, &sky_keys()).map_err(wrong(sky_file))?,
            sun: parse(sun_csv, SUN_HEADER, &sun_keys()).map_err(wrong(sun_file))?,
        })
    }

    /// The coefficients that this build embeds; none without the feature `coefficients`.
    #[must_use]
    pub fn embedded() -> Option<&'static Self> {
        #[cfg(feature = "coefficients")]
        return Some(&EMBEDDED);
        #[cfg(not(feature = "coefficients"))]
        return None;
    }

    /// The values of one control point of the sky at one wavelength, linear in turbidity and ground albedo.
    pub(crate) fn sky(
        &self,
        turbidity: TurbidityLevel,
        ground_albedo: f64,
        control_point: usize,
        node: usize,
    ) -> [f64; SKY_VALUES] {
        turbidity.interpolate(|level| {
            let row = |albedo: usize| self.sky[((2 * level + albedo) * CONTROL_POINTS + control_point) * NODES + node];
            between(&row(0), &row(1), ground_albedo)
        })
    }

    /// The polynomial of one segment of the sun's radiance at one wavelength, linear in turbidity.
    pub(crate) fn sun(&self, turbidity: TurbidityLevel, segment: usize, node: usize) -> [f64; 4] {
        turbidity.interpolate(|level| self.sun[(level * SEGMENTS + segment) * NODES + node])
    }
}

#[cfg(feature = "coefficients")]
static EMBEDDED: LazyLock<Coefficients> = LazyLock::new(|| {
    let files =
        [include_str!("../data/hosek_wilkie_2012_spectral.csv"), include_str!("../data/hosek_wilkie_2013_sun.csv")];
    Coefficients::parse(files[0], files[1]).unwrap_or_else(|error| unreachable!("{error}"))
});

/// The polynomial of the limb darkening at one wavelength.
pub(crate) fn limb_darkening(node: usize) -> [f64; 6] {
    LIMB_DARKENING[node]
}

/// (1 − f) `below` + f `above`.
fn between<const N: usize>(below: &[f64; N], above: &[f64; N], fraction: f64) -> [f64; N] {
    std::array::from_fn(|index| (1.0 - fraction) * below[index] + fraction * above[index])
}

/// The value at a wavelength in nm, linear between the values at [`WAVELENGTHS_NM`].
///
/// # Panics
/// If the wavelength lies outside 320–720 nm.
#[must_use]
pub fn at_wavelength(values: &[f64; NODES], wavelength_nm: f64) -> f64 {
    let (first_nm, last_nm) = (WAVELENGTHS_NM[0], WAVELENGTHS_NM[NODES - 1]);
    assert!(
        (first_nm..=last_nm).contains(&wavelength_nm),
        "wavelength is {wavelength_nm} nm, but must lie in {first_nm}–{last_nm} nm"
    );
    let above = WAVELENGTHS_NM.partition_point(|known_nm| *known_nm <= wavelength_nm).min(NODES - 1);
    let (lower_nm, upper_nm) = (WAVELENGTHS_NM[above - 1], WAVELENGTHS_NM[above]);
    let fraction = (wavelength_nm - lower_nm) / (upper_nm - lower_nm);
    (1.0 - fraction) * values[above - 1] + fraction * values[above]
}

/// The polynomial with the given coefficients, constant first.
pub(crate) fn polynomial<const N: usize>(coefficients: &[f64; N], x: f64) -> f64 {
    coefficients.iter().rev().fold(0.0, |sum, coefficient| sum * x + coefficient)
}

/// The wavelengths, in nm, as whole numbers.
fn wavelengths() -> impl Iterator<Item = u32> + Clone {
    (320..=720).step_by(40)
}

/// Turbidity, ground albedo, control point and wavelength of each row of the table of the sky.
fn sky_keys() -> Vec<[u32; 4]> {
    let mut keys = Vec::new();
    for turbidity in 1..=10 {
        for albedo in 0..=1 {
            for point in 0..6 {
                keys.extend(wavelengths().map(|nm| [turbidity, albedo, point, nm]));
            }
        }
    }
    keys
}

/// Turbidity, segment and wavelength of each row of the table of the sun.
fn sun_keys() -> Vec<[u32; 3]> {
    let mut keys = Vec::new();
    for turbidity in 1..=10 {
        for segment in 0..45 {
            keys.extend(wavelengths().map(|nm| [turbidity, segment, nm]));
        }
    }
    keys
}

/// The `N` values after the keys of each line. The error names the line, counted from 1.
fn parse<const K: usize, const N: usize>(csv: &str, header: &str, keys: &[[u32; K]]) -> Result<Vec<[f64; N]>, String> {
    let mut lines = csv.lines();
    if lines.next() != Some(header) {
        return Err(format!("line 1 must be `{header}`"));
    }
    let rows = keys.iter().enumerate().map(|(index, keys)| {
        let wrong = || format!("line {} must have the keys {keys:?} and {N} numbers", index + 2);
        let mut fields = lines.next().ok_or_else(wrong)?.split(',');
        if !keys.iter().all(|key| fields.next().and_then(|field| field.parse().ok()) == Some(*key)) {
            return Err(wrong());
        }
        let mut values = [0.0; N];
        for value in &mut values {
            let number: Option<f64> = fields.next().and_then(|field| field.parse().ok());
            *value = number.filter(|number| number.is_finite()).ok_or_else(wrong)?;
        }
        Ok(values)
    });
    let rows = rows.collect::<Result<_, _>>()?;
    match lines.next() {
        None => Ok(rows),
        Some(_) => Err(format!("it has more than {} lines", keys.len() + 1)),
    }
}

/// As [`parse`], for a table that ships with this crate.
pub(crate) fn shipped<const K: usize, const N: usize>(csv: &str, header: &str, keys: &[[u32; K]]) -> Vec<[f64; N]> {
    parse(csv, header, keys).unwrap_or_else(|reason| unreachable!("a table that ships with this crate: {reason}"))
}

#[cfg(test)]
#[expect(clippy::float_cmp, reason = "numbers of the tables, and sums without rounding")]
mod tests {
    use super::*;

    fn embedded() -> &'static Coefficients {
        Coefficients::embedded().unwrap()
    }

    #[test]
    fn wavelengths_are_those_of_the_rows() {
        assert_eq!(WAVELENGTHS_NM.to_vec(), wavelengths().map(f64::from).collect::<Vec<_>>());
    }

    #[test]
    fn a_file_of_coefficients_that_is_not_whole_is_refused_in_one_line() {
        let [sky, sun] = ["spectral", "sun"].map(|name| {
            let year = if name == "sun" { 2013 } else { 2012 };
            let path = format!("{}/data/hosek_wilkie_{year}_{name}.csv", env!("CARGO_MANIFEST_DIR"));
            std::fs::read_to_string(path).unwrap()
        });
        assert_eq!(&Coefficients::parse(&sky, &sun).unwrap(), embedded());
        let message = |sky: &str, sun: &str| Coefficients::parse(sky, sun).unwrap_err().to_string();
        let page = "<!doctype html>";
        assert_eq!(
            message(&sky, page),
            "hosek_wilkie_2013_sun.csv: line 1 must be `turbidity,segment,wavelength_nm,c0,c1,c2,c3`"
        );
        let cut = &sky[..sky.len() / 2];
        let line = cut.lines().count();
        assert!(message(cut, &sun).starts_with(&format!("hosek_wilkie_2012_spectral.csv: line {line} must have")));
        let swapped = sun.replacen("1,0,320", "1,1,320", 1);
        let reason = "line 2 must have the keys [1, 0, 320] and 4 numbers";
        assert_eq!(message(&sky, &swapped), format!("hosek_wilkie_2013_sun.csv: {reason}"));
        let infinite = sun.replacen("1,0,320,0.0", "1,0,320,inf", 1);
        assert_eq!(message(&sky, &infinite), format!("hosek_wilkie_2013_sun.csv: {reason}"));
        assert!(message(&sky, &format!("{sun}\n")).ends_with("it has more than 4951 lines"));
    }

    /// The first, a middle and the last row of each table, as they ship with Mitsuba 3.9.1.
    #[test]
    fn rows_have_their_values() {
        let Coefficients { sky, sun } = embedded();
        assert_eq!((sky.len(), sun.len()), (1320, 4950));
        assert_eq!(sky[0][..3], [0.000_928_201_6, -13.410_49, -3.742_293]);
        assert_eq!(sky[1319][..3], [0.163_988_4, -0.976_267_1, -0.336_835_5]);
        assert_eq!(embedded().sky(TurbidityLevel::new(1.0), 0.0, 0, 10)[9], 0.721_649_5);
        assert_eq!(sun[2], [0.022_888_13, -434.083_7, -16_294_270.0, 1_117_129_000_000.0]);
        assert_eq!(sun[4949], [13_136.97, 425.547_4, -48.326_54, -12_885.15]);
        assert_eq!(embedded().sun(TurbidityLevel::new(1.0), 2, 3), [2.120_77, 287.717_2, -852_213.9, 1_570_174_000.0]);
        assert_eq!(limb_darkening(0), [0.087_657, 0.767_174, 0.658_123, -1.029_53, 0.703_297, -0.186_735]);
        assert_eq!(limb_darkening(10)[5], 0.440_004);
    }

    #[test]
    fn turbidity_is_interpolated_linearly() {
        let level = |turbidity| TurbidityLevel::new(turbidity);
        assert_eq!(level(1.0), TurbidityLevel { below: 0, fraction: 0.0 });
        assert_eq!(level(2.25), TurbidityLevel { below: 1, fraction: 0.25 });
        assert_eq!(level(9.0), TurbidityLevel { below: 8, fraction: 0.0 });
        assert_eq!(level(10.0), TurbidityLevel { below: 8, fraction: 1.0 });
        let sun = |turbidity| embedded().sun(level(turbidity), 20, 5)[0];
        assert!((sun(3.5) - 0.5 * (sun(3.0) + sun(4.0))).abs() < 1e-12 * sun(3.5));
        let sky = |ground_albedo| embedded().sky(level(2.0), ground_albedo, 3, 4)[0];
        assert!((sky(0.5) - 0.5 * (sky(0.0) + sky(1.0))).abs() < 1e-15);
    }

    #[test]
    fn values_are_linear_between_wavelengths() {
        let values = WAVELENGTHS_NM.map(|nm| 2.0 * nm);
        for wavelength_nm in [320.0, 333.0, 360.0, 555.5, 720.0] {
            assert!((at_wavelength(&values, wavelength_nm) - 2.0 * wavelength_nm).abs() < 1e-12);
        }
    }

    #[test]
    #[should_panic(expected = "wavelength is 721 nm, but must lie in 320–720 nm")]
    fn wavelengths_outside_the_tables_panic() {
        let _ = at_wavelength(&[0.0; 11], 721.0);
    }

    #[test]
    fn polynomials_start_with_their_constant() {
        assert_eq!(polynomial(&[1.0, 2.0, 3.0], 2.0), 17.0);
    }
}
