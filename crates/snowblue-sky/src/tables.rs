//! The coefficients of Hosek & Wilkie, as they ship in `data/`.

use std::sync::LazyLock;

/// The wavelengths of the tables, in nm.
pub const WAVELENGTHS_NM: [f64; NODES] = [320.0, 360.0, 400.0, 440.0, 480.0, 520.0, 560.0, 600.0, 640.0, 680.0, 720.0];

/// Number of wavelengths of the tables.
pub(crate) const NODES: usize = 11;

/// The first and the last turbidity of the tables; they have every whole number between them.
pub(crate) const TURBIDITY_RANGE: (f64, f64) = (1.0, 10.0);

/// Control points of the Bézier curves in the elevation of the sun.
pub(crate) const CONTROL_POINTS: usize = 6;

/// Segments of the polynomials of the sun's radiance.
pub(crate) const SEGMENTS: usize = 45;

/// Numbers of a row of the table of the sky: a radiance in W m⁻² sr⁻¹ nm⁻¹, then p0–p8.
pub(crate) const SKY_VALUES: usize = 10;

static SKY: LazyLock<Vec<[f64; SKY_VALUES]>> = LazyLock::new(|| {
    parse(
        include_str!("../data/hosek_wilkie_2012_spectral.csv"),
        "turbidity,ground_albedo,control_point,wavelength_nm,radiance,p0,p1,p2,p3,p4,p5,p6,p7,p8",
    )
});

static SUN: LazyLock<Vec<[f64; 4]>> = LazyLock::new(|| {
    parse(include_str!("../data/hosek_wilkie_2013_sun.csv"), "turbidity,segment,wavelength_nm,c0,c1,c2,c3")
});

static LIMB_DARKENING: LazyLock<Vec<[f64; 6]>> = LazyLock::new(|| {
    parse(include_str!("../data/hosek_wilkie_2013_limb_darkening.csv"), "wavelength_nm,a0,a1,a2,a3,a4,a5")
});

/// The position of a turbidity between the two nearest of the tables.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct TurbidityLevel {
    /// Index of the lower one, at most 8.
    below: usize,
    /// 0 at the lower one, 1 at the one above it.
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

/// The values of one control point of the sky at one wavelength, linear in turbidity and ground albedo.
pub(crate) fn sky(
    turbidity: TurbidityLevel,
    ground_albedo: f64,
    control_point: usize,
    node: usize,
) -> [f64; SKY_VALUES] {
    turbidity.interpolate(|level| {
        let row = |albedo: usize| SKY[((2 * level + albedo) * CONTROL_POINTS + control_point) * NODES + node];
        between(&row(0), &row(1), ground_albedo)
    })
}

/// The polynomial of one segment of the sun's radiance at one wavelength, linear in turbidity.
pub(crate) fn sun(turbidity: TurbidityLevel, segment: usize, node: usize) -> [f64; 4] {
    turbidity.interpolate(|level| SUN[(level * SEGMENTS + segment) * NODES + node])
}

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

/// The last `N` fields of each line after the header.
///
/// # Panics
/// If a table that ships with this crate has another header or is not numeric.
fn parse<const N: usize>(csv: &str, header: &str) -> Vec<[f64; N]> {
    let mut lines = csv.lines();
    assert_eq!(lines.next(), Some(header), "unexpected header");
    let number = |field: &str| field.parse().unwrap_or_else(|_| unreachable!("`{field}` is not a number"));
    let row = |line: &str| {
        let mut values = [0.0; N];
        line.rsplit(',').zip(values.iter_mut().rev()).for_each(|(field, value)| *value = number(field));
        values
    };
    lines.map(row).collect()
}

#[cfg(test)]
#[expect(clippy::float_cmp, reason = "numbers of the tables, and sums without rounding")]
mod tests {
    use super::*;

    /// The keys of each row of a table: its first `N` fields.
    fn keys<const N: usize>(csv: &str) -> Vec<[u32; N]> {
        let row = |line: &str| {
            let mut fields = line.split(',');
            std::array::from_fn(|_| fields.next().unwrap().parse().unwrap())
        };
        csv.lines().skip(1).map(row).collect()
    }

    fn wavelengths() -> impl Iterator<Item = u32> + Clone {
        (320..=720).step_by(40)
    }

    #[test]
    fn rows_have_the_order_that_the_indices_assume() {
        let mut expected = Vec::new();
        for turbidity in 1..=10 {
            for albedo in 0..=1 {
                for point in 0..6 {
                    expected.extend(wavelengths().map(|nm| [turbidity, albedo, point, nm]));
                }
            }
        }
        assert_eq!(keys(include_str!("../data/hosek_wilkie_2012_spectral.csv")), expected);

        let mut expected = Vec::new();
        for turbidity in 1..=10 {
            for segment in 0..45 {
                expected.extend(wavelengths().map(|nm| [turbidity, segment, nm]));
            }
        }
        assert_eq!(keys(include_str!("../data/hosek_wilkie_2013_sun.csv")), expected);

        let expected: Vec<[u32; 1]> = wavelengths().map(|nm| [nm]).collect();
        assert_eq!(keys(include_str!("../data/hosek_wilkie_2013_limb_darkening.csv")), expected);
        assert_eq!(WAVELENGTHS_NM.to_vec(), wavelengths().map(f64::from).collect::<Vec<_>>());
    }

    /// The first, a middle and the last row of each table, as they ship with Mitsuba 3.9.1.
    #[test]
    fn rows_have_their_values() {
        assert_eq!((SKY.len(), SUN.len(), LIMB_DARKENING.len()), (1320, 4950, 11));
        assert_eq!(SKY[0][..3], [0.000_928_201_6, -13.410_49, -3.742_293]);
        assert_eq!(SKY[1319][..3], [0.163_988_4, -0.976_267_1, -0.336_835_5]);
        assert_eq!(sky(TurbidityLevel::new(1.0), 0.0, 0, 10)[9], 0.721_649_5);
        assert_eq!(SUN[2], [0.022_888_13, -434.083_7, -16_294_270.0, 1_117_129_000_000.0]);
        assert_eq!(SUN[4949], [13_136.97, 425.547_4, -48.326_54, -12_885.15]);
        assert_eq!(sun(TurbidityLevel::new(1.0), 2, 3), [2.120_77, 287.717_2, -852_213.9, 1_570_174_000.0]);
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
        let middle = sun(level(3.5), 20, 5)[0];
        assert!((middle - 0.5 * (sun(level(3.0), 20, 5)[0] + sun(level(4.0), 20, 5)[0])).abs() < 1e-12 * middle);
        let half = sky(level(2.0), 0.5, 3, 4)[0];
        assert!((half - 0.5 * (sky(level(2.0), 0.0, 3, 4)[0] + sky(level(2.0), 1.0, 3, 4)[0])).abs() < 1e-15);
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
