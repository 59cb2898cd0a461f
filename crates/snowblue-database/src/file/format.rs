//! Definitions shared by the reader and the writer of files: names, and the packing of integers on axes into few
//! bytes.
//!
//! **Packed integers.** Neighbours on an axis are similar, so files store the differences along every axis, one axis
//! after another (the Lorenzo predictor of Ibarria et al. 2003, doi:10.1111/1467-8659.00681). The value before the
//! first value of an axis is 0. The differences of the first component come first, then the differences of the second
//! component, and so on, in the order of the axes.
//!
//! A difference d becomes the number n = 2d for d ≥ 0 and −2d − 1 for d < 0, and n becomes an exponential Golomb code
//! of order k (Teuhola 1978, doi:10.1016/0020-0190(78)90024-8): n + 2ᵏ in binary, after as many zeros as this number
//! has digits beyond k + 1. The order k adapts to the numbers of a component: k = ⌊log₂(s/16)⌋, but at least 0, with
//! s = 0 before the first number and s ← s − ⌊s/8⌋ + n after each number. The highest bit of a byte comes first.
//! Zeros fill the last byte.

use crate::Axes;

pub(super) const COMPONENT: &str = "component";
pub(super) const SINGULAR_VALUE: &str = "singular_value";
/// Ending of the names of packed coefficients.
pub(super) const PACKED_SUFFIX: &str = "_packed";
/// Dimensions of the bytes of packed coefficients, of transmittance and reflectance.
pub(super) const PACKED_DIMENSIONS: [&str; 2] = ["transmittance_byte", "reflectance_byte"];
/// The attribute of packed coefficients that has their step.
pub(super) const STEP: &str = "packing_step";
pub(super) const SPACE: &str = "space";
pub(super) const SHARD: &str = "shard";
pub(super) const ARITHMETIC: &str = "arithmetic";
pub(super) const GRAIN: &str = "grain";
pub(super) const SAMPLE: &str = "sample";
pub(super) const SHARD_DIMENSIONS: [&str; 5] = [GRAIN, SAMPLE, "angle", "thickness", "wavelength"];
/// Ending of the names of standard errors.
pub(super) const ERROR_SUFFIX: &str = "_standard_error";
/// The attribute that names the conventions of a file.
pub(super) const CONVENTIONS: &str = "Conventions";

/// The greatest absolute integer. Single precision holds all up to it.
pub(super) const GREATEST: i32 = 1 << 24;

/// Lengths of the axes of coefficients: all axes of a table except the wavelength.
pub(super) fn lengths(axes: &Axes) -> Vec<usize> {
    let mut lengths: Vec<usize> = axes.named().iter().map(|axis| axis.values.len()).collect();
    lengths.pop();
    lengths
}

/// Packs integers of all components on axes of the given lengths. The component runs fastest.
pub(super) fn pack(mut integers: Vec<i32>, lengths: &[usize], components: usize) -> Vec<u8> {
    for (stride, length) in strides(lengths, components) {
        for block in integers.chunks_exact_mut(stride * length) {
            for index in (stride..block.len()).rev() {
                block[index] = block[index].wrapping_sub(block[index - stride]);
            }
        }
    }
    let mut bits = Vec::new();
    for component in 0..components {
        let mut order = Order::default();
        for difference in integers.iter().skip(component).step_by(components) {
            let number = ((difference << 1) ^ (difference >> 31)).cast_unsigned();
            let code = u64::from(number) + (1 << order.get());
            let zeros = code.ilog2() - order.get();
            let digits = zeros + code.ilog2() + 1;
            bits.extend((0..digits).rev().map(|digit| u8::from(digit < 64 && code >> digit & 1 == 1)));
            order.follow(number);
        }
    }
    bits.chunks(8).map(|byte| byte.iter().zip((0..8).rev()).map(|(bit, place)| bit << place).sum()).collect()
}

/// Unpacks the integers that [`pack`] packed.
///
/// # Errors
/// A short description of the error in the bytes.
pub(super) fn unpack(bytes: &[u8], lengths: &[usize], components: usize) -> Result<Vec<i32>, &'static str> {
    const SHORT: &str = "there are too few";
    let count = lengths.iter().try_fold(components, |product, length| product.checked_mul(*length)).ok_or(SHORT)?;
    // A code has at least one bit, so the number of bytes bounds the memory.
    if count.div_ceil(8) > bytes.len() {
        return Err(SHORT);
    }
    let mut bits = bytes.iter().flat_map(|byte| (0..8).rev().map(move |place| byte >> place & 1));
    let mut integers = vec![0_i32; count];
    for component in 0..components {
        let mut order = Order::default();
        for difference in integers.iter_mut().skip(component).step_by(components) {
            let zeros = bits.by_ref().position(|bit| bit == 1).ok_or(SHORT)?;
            let zeros = u32::try_from(zeros).ok().filter(|zeros| *zeros <= u32::BITS).ok_or("a number is too large")?;
            let mut code = 1_u64;
            for _ in 0..zeros + order.get() {
                code = code << 1 | u64::from(bits.next().ok_or(SHORT)?);
            }
            let number = u32::try_from(code - (1 << order.get())).map_err(|_| "a number is too large")?;
            *difference = (number >> 1).cast_signed() ^ -(number & 1).cast_signed();
            order.follow(number);
        }
    }
    if bits.by_ref().take(7).any(|bit| bit == 1) || bits.next().is_some() {
        return Err("there are too many");
    }
    for (stride, length) in strides(lengths, components) {
        for block in integers.chunks_exact_mut(stride * length) {
            for index in stride..block.len() {
                block[index] = block[index].wrapping_add(block[index - stride]);
            }
        }
    }
    if integers.iter().any(|integer| integer.unsigned_abs() > GREATEST.unsigned_abs()) {
        return Err("a number is too large");
    }
    Ok(integers)
}

/// Distance of neighbours on each axis, and its length.
fn strides(lengths: &[usize], components: usize) -> impl Iterator<Item = (usize, usize)> {
    lengths.iter().rev().scan(components, |stride, length| {
        let own = *stride;
        *stride *= length;
        Some((own, *length))
    })
}

/// The order of the next code.
#[derive(Default)]
struct Order {
    /// About eight times the mean of the last numbers.
    sum: u64,
}

impl Order {
    fn get(&self) -> u32 {
        (self.sum / 16).checked_ilog2().unwrap_or(0)
    }

    fn follow(&mut self, number: u32) {
        self.sum = self.sum - self.sum / 8 + u64::from(number);
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used, reason = "a test may panic")]

    use super::*;
    use proptest::prelude::*;

    /// The codes of 0, −1 and 1 at order 0 are 1, 010 and 011.
    #[test]
    fn the_first_codes_are_those_of_the_format() {
        assert_eq!(pack(vec![0, -1, 0], &[3], 1), [0b1010_0110]);
        assert_eq!(unpack(&[0b1010_0110], &[3], 1).unwrap(), [0, -1, 0]);
    }

    /// A sum of terms of single axes has differences other than 0 only at the start of an axis.
    #[test]
    fn sums_of_terms_of_the_axes_take_a_bit_each() {
        let integers: Vec<i32> = (0..10 * 20 * 30).map(|i| 3 * (i / 600) + 5 * (i / 30 % 20) - i % 30).collect();
        let packed = pack(integers.clone(), &[10, 20, 30], 1);
        assert!(packed.len() < 6000 / 8 + 60, "{}", packed.len());
        assert_eq!(unpack(&packed, &[10, 20, 30], 1).unwrap(), integers);
    }

    proptest! {
        #[test]
        fn integers_are_unpacked_as_packed(
            integers in prop::collection::vec(-GREATEST..=GREATEST, 2 * 3 * 4 * 2),
            shift in 0..25,
        ) {
            let integers: Vec<i32> = integers.iter().map(|integer| integer >> shift).collect();
            let packed = pack(integers.clone(), &[2, 3, 4], 2);
            prop_assert_eq!(unpack(&packed, &[2, 3, 4], 2), Ok(integers));
            prop_assert!(unpack(&packed[..packed.len() - 1], &[2, 3, 4], 2).is_err());
            prop_assert_eq!(unpack(&[&packed[..], &[0]].concat(), &[2, 3, 4], 2), Err("there are too many"));
        }

        #[test]
        fn any_bytes_are_read_or_refused(bytes in prop::collection::vec(any::<u8>(), 0..200)) {
            if let Ok(integers) = unpack(&bytes, &[2, 5], 3) {
                prop_assert_eq!(pack(integers, &[2, 5], 3), bytes);
            }
        }
    }

    #[test]
    fn axes_that_the_bytes_cannot_hold_take_no_memory() {
        assert!(unpack(&[0xff; 100], &[1 << 20, 1 << 20], 31).is_err());
        assert!(unpack(&[0xff; 100], &[usize::MAX, 2], 31).is_err());
        assert!(unpack(&[0; 100], &[10], 1).is_err());
    }
}
