//! Transfer functions: from linear channel values to the code values of files, and back.

/// sRGB code value in 0–1 of a linear value in 0–1 (IEC 61966-2-1:1999).
///
/// 12.92 v up to v = 0.0031308, above 1.055 v^(1/2.4) − 0.055.
pub fn encode_srgb(linear: f64) -> f64 {
    if linear <= 0.0031308 { 12.92 * linear } else { 1.055 * linear.powf(1.0 / 2.4) - 0.055 }
}

/// Linear value of an sRGB code value in 0–1: the inverse of [`encode_srgb`].
pub fn decode_srgb(code: f64) -> f64 {
    if code <= 0.04045 { code / 12.92 } else { ((code + 0.055) / 1.055).powf(2.4) }
}

/// Rec. 2020 code value in 0–1 of a linear value in 0–1 (ITU-R BT.2020-2, table 4, with unrounded constants).
///
/// 4.5 v below v = β, else α v^0.45 − (α − 1).
pub fn encode_rec2020(linear: f64) -> f64 {
    const ALPHA: f64 = 1.099_296_826_809_44;
    if linear < REC2020_BETA { 4.5 * linear } else { ALPHA * linear.powf(0.45) - (ALPHA - 1.0) }
}

const REC2020_BETA: f64 = 0.018_053_968_510_807;

#[cfg(test)]
mod tests {
    use super::*;

    /// The constants of IEC 61966-2-1 are rounded: the branches differ by 3e-8 where they join.
    #[test]
    fn srgb_encoding_and_decoding_are_inverse() {
        for step in 0..=1000 {
            let linear = f64::from(step) / 1000.0;
            let decoded = decode_srgb(encode_srgb(linear));
            assert!((decoded - linear).abs() < 1e-7, "{linear} {decoded}");
        }
        assert!((encode_srgb(0.0031308) - encode_srgb(0.003_130_800_1)).abs() < 1e-7);
    }

    /// BT.2020-2 chooses α and β such that value and slope are continuous.
    #[test]
    fn rec2020_branches_join_smoothly() {
        let at_joint = encode_rec2020(REC2020_BETA);
        assert!((at_joint - 4.5 * REC2020_BETA).abs() < 1e-14);
        assert!(((encode_rec2020(REC2020_BETA + 1e-6) - at_joint) / 1e-6 - 4.5).abs() < 1e-3);
    }

    #[test]
    fn black_and_white_keep_their_values() {
        for encode in [encode_srgb, encode_rec2020] {
            assert!(encode(0.0).abs() < 1e-15);
            assert!((encode(1.0) - 1.0).abs() < 1e-14);
        }
    }
}
