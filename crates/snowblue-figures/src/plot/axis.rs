//! Axes with round marks, linear or logarithmic.

/// A range of values with marks.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Axis {
    pub(crate) low: f64,
    pub(crate) high: f64,
    pub(crate) logarithmic: bool,
    pub(crate) marks: Vec<f64>,
    /// Distance between linear marks; sets their decimals.
    pub(crate) step: f64,
}

impl Axis {
    /// A linear axis over exactly this range, with about `count` round marks.
    pub(crate) fn linear(low: f64, high: f64, count: f64) -> Self {
        Self::in_steps(low, high, round_step((high - low) / count))
    }

    fn in_steps(low: f64, high: f64, step: f64) -> Self {
        let (first, last) = ((low / step - 1e-9).ceil(), (high / step + 1e-9).floor());
        let marks = (0_u32..).map(|i| first + f64::from(i)).take_while(|i| *i <= last).map(|i| i * step).collect();
        Self { low, high, logarithmic: false, marks, step }
    }

    /// A linear axis, widened to end on marks.
    pub(crate) fn linear_to_marks(low: f64, high: f64, count: f64) -> Self {
        let high = if high > low { high } else { low + low.abs().max(1e-3) };
        let step = round_step((high - low) / count);
        Self::in_steps((low / step + 1e-9).floor() * step, (high / step - 1e-9).ceil() * step, step)
    }

    /// A logarithmic axis, marked at powers of ten and, up to 3.5 decades, at 2 and 5 times these.
    pub(crate) fn logarithmic(low: f64, high: f64) -> Self {
        let decades = (high / low).log10();
        let factors: &[f64] = if decades > 3.5 { &[1.0] } else { &[1.0, 2.0, 5.0] };
        let apart = (decades / 8.0).ceil().max(1.0);
        let exponents = (0_u32..).map(|i| low.log10().floor() + f64::from(i)).take_while(|e| *e <= high.log10());
        let marks = exponents
            .filter(|exponent| (exponent / apart).fract().abs() < 1e-9)
            .flat_map(|exponent| factors.iter().map(move |factor| factor * 10_f64.powf(exponent)))
            .filter(|mark| (low * 0.999..=high * 1.001).contains(mark))
            .collect();
        Self { low, high, logarithmic: true, marks, step: 0.0 }
    }

    /// Position of a value between both ends, 0–1; values beyond an end are at that end.
    pub(crate) fn fraction(&self, value: f64) -> f64 {
        let fraction = if self.logarithmic {
            (value.max(f64::MIN_POSITIVE) / self.low).ln() / (self.high / self.low).ln()
        } else {
            (value - self.low) / (self.high - self.low)
        };
        fraction.clamp(0.0, 1.0)
    }

    pub(crate) fn label(&self, mark: f64) -> String {
        let (size, least) = if self.logarithmic { (mark, self.low) } else { (self.step, self.step) };
        if least < 0.999e-4 && mark != 0.0 {
            return power_of_ten(mark);
        }
        let decimals = if size < 1.0 { -(size * 1.001).log10().floor() } else { 0.0 };
        #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "0 ≤ decimals ≤ 4")]
        let decimals = decimals as usize;
        format!("{mark:.decimals$}").replace('-', "−")
    }
}

/// The next of 1, 2, 5 times a power of ten.
fn round_step(step: f64) -> f64 {
    let power = 10_f64.powf(step.log10().floor());
    let factor = [1.0, 2.0, 5.0].into_iter().find(|factor| step <= factor * power * 1.001).unwrap_or(10.0);
    factor * power
}

/// 3·10⁻⁷ for 3e-7, and 1 for 1.
pub(super) fn power_of_ten(value: f64) -> String {
    let digits = format!("{value:.1e}");
    let (factor, exponent) = digits.split_once('e').unwrap_or((&digits, "0"));
    let raised = |digit: char| match digit {
        '-' => '⁻',
        '1' => '¹',
        '2' => '²',
        '3' => '³',
        _ => char::from_u32(0x2070 + digit.to_digit(10).unwrap_or(0)).unwrap_or(digit),
    };
    let power: String = exponent.chars().map(raised).collect();
    match factor.trim_end_matches(".0") {
        "1" if exponent == "0" => "1".to_owned(),
        "1" => format!("10{power}"),
        factor => format!("{factor}·10{power}"),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn axes_end_on_round_marks() {
        let axis = Axis::linear_to_marks(0.0, 0.0437, 4.0);
        assert_eq!((axis.fraction(0.0), axis.label(axis.high)), (0.0, "0.06".to_owned()));
        let axis = Axis::linear_to_marks(0.8785, 0.8985, 4.0);
        assert_eq!((axis.label(axis.low), axis.label(axis.high)), ("0.875".to_owned(), "0.900".to_owned()));
        let labels = |axis: &Axis| axis.marks.iter().map(|mark| axis.label(*mark)).collect::<Vec<_>>();
        assert_eq!(labels(&Axis::linear(400.0, 700.0, 6.0)), ["400", "450", "500", "550", "600", "650", "700"]);
        assert_eq!(labels(&Axis::logarithmic(0.01, 0.5)), ["0.01", "0.02", "0.05", "0.1", "0.2", "0.5"]);
        assert_eq!(labels(&Axis::logarithmic(1e-4, 1.0)), ["0.0001", "0.001", "0.01", "0.1", "1"]);
        assert_eq!(labels(&Axis::logarithmic(1e-5, 1.0)), ["10⁻⁵", "10⁻⁴", "10⁻³", "10⁻²", "10⁻¹", "1"]);
        assert!(labels(&Axis::logarithmic(1e-30, 1.0)).len() < 10);
        assert_eq!(power_of_ten(2.5e-12), "2.5·10⁻¹²");
    }
}
