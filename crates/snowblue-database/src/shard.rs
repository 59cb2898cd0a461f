//! A table in parts, filled by independent machines.
//!
//! Part i of n holds some of the table's grains (size × facetness). Grains are ordered with the facetness running
//! slower, since each facetness costs a grain tally, and part i is the i-th of n consecutive runs. The values of a
//! part are bit for bit equal to the values of the whole table, so a merged table equals the table that a single
//! machine would have filled. Shards are not merged if the mathematical functions of their machines round
//! differently.

use std::fmt;
use std::str::FromStr;

use crate::fill::{self, FillOptions, FillProgress};
use crate::table::{Attribute, CurveValues, Quantity, StandardErrors};
use crate::{Axes, DatabaseError, Table};

/// A part of a table.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Part {
    /// Number of the part, from 1.
    pub number: usize,
    /// Number of parts.
    pub of: usize,
}

/// The values of a part of a table.
#[derive(Debug, Clone, PartialEq)]
pub struct Shard {
    /// Axes of the whole table.
    pub axes: Axes,
    /// The part.
    pub part: Part,
    /// The values of its grains, in the order of [`Part::grains`].
    pub values: CurveValues,
    /// Provenance.
    pub metadata: Vec<Attribute>,
    /// [`math_fingerprint`] of the machine that filled it.
    pub arithmetic: String,
}

/// A shard with a name for messages, such as its file's.
#[derive(Debug, Clone, PartialEq)]
pub struct NamedShard {
    /// The name.
    pub name: String,
    /// The shard.
    pub shard: Shard,
}

/// A fingerprint of the machine's exponentials, logarithms and cosines.
///
/// These functions come from the system's C library, which has variants for different processors. The last bits of
/// the functions change the values of a table by 10⁻¹³. Shards of different fingerprints would make a table that
/// differs from the table of either machine.
#[must_use]
pub fn math_fingerprint() -> String {
    let mut hash = 0xcbf2_9ce4_8422_2325_u64;
    for step in 1..=2000 {
        let x = 0.01 * f64::from(step);
        for value in [(-x).exp(), (-x).exp_m1(), x.ln(), x.cos(), x.tanh(), x.powf(0.37)] {
            // FNV-1a (Fowler, Noll & Vo), one double at a time.
            hash = (hash ^ value.to_bits()).wrapping_mul(0x0100_0000_01b3);
        }
    }
    format!("{hash:016x}")
}

impl Part {
    /// The grains of this part. The sizes of the parts differ by at most one grain.
    #[must_use]
    pub fn grains(self, axes: &Axes) -> Vec<usize> {
        let (sizes, kinds) = (axes.grain_sizes_um.len(), axes.facetness.len());
        let at = |part: usize| axes.grains() * part / self.of;
        (at(self.number - 1)..at(self.number)).map(|place| (place % sizes) * kinds + place / sizes).collect()
    }

    /// Checks that the part exists and is not empty.
    ///
    /// # Errors
    /// [`DatabaseError::Part`] otherwise.
    pub fn check(self, axes: &Axes) -> Result<(), DatabaseError> {
        let Self { number, of } = self;
        let grains = axes.grains();
        let exists = (1..=of).contains(&number) && of <= grains;
        if exists { Ok(()) } else { Err(DatabaseError::Part { number, of, grains }) }
    }
}

/// `2/8`.
impl fmt::Display for Part {
    fn fmt(&self, out: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(out, "{}/{}", self.number, self.of)
    }
}

impl FromStr for Part {
    type Err = String;

    fn from_str(words: &str) -> Result<Self, String> {
        let numbers = words.split_once('/').map(|(number, of)| (number.trim().parse(), of.trim().parse()));
        match numbers {
            Some((Ok(number), Ok(of))) => Ok(Self { number, of }),
            _ => Err("give PART/PARTS (2/8)".to_owned()),
        }
    }
}

/// Fills one part of the table that [`fill::fill`] fills.
///
/// # Errors
/// If the part does not exist, or an axis or option is out of range.
pub fn fill_part(
    axes: &Axes,
    options: &FillOptions,
    part: Part,
    progress: &(dyn Fn(FillProgress) + Sync),
) -> Result<Shard, DatabaseError> {
    part.check(axes)?;
    let values = fill::fill_grains(axes, options, &part.grains(axes), progress)?;
    Ok(Shard { axes: axes.clone(), part, values, metadata: options.metadata(), arithmetic: math_fingerprint() })
}

/// Merges all parts of a table.
///
/// # Errors
/// [`DatabaseError::Shards`] if a part is missing, occurs twice, or belongs to another table.
pub fn merge(shards: &[NamedShard]) -> Result<Table, DatabaseError> {
    check(shards)?;
    let first = &shards[0].shard;
    let gather = |values: &dyn Fn(&CurveValues) -> &[f64]| {
        let per_grain = first.axes.curves() / first.axes.grains() * first.axes.wavelengths_nm.len();
        let mut whole = vec![0.0; first.axes.grains() * per_grain];
        for NamedShard { shard, .. } in shards {
            let blocks = values(&shard.values).chunks_exact(per_grain);
            for (grain, block) in shard.part.grains(&shard.axes).into_iter().zip(blocks) {
                whole[grain * per_grain..][..per_grain].copy_from_slice(block);
            }
        }
        whole
    };
    let error = |quantity: Quantity| gather(&|values| values.errors.as_ref().map_or(&[], |errors| errors.of(quantity)));
    let errors = first.values.errors.is_some().then(|| StandardErrors {
        transmittance: error(Quantity::Transmittance),
        reflectance: error(Quantity::Reflectance),
    });
    let values = CurveValues {
        transmittance: gather(&|values| &values.transmittance),
        reflectance: gather(&|values| &values.reflectance),
        errors,
    };
    Ok(Table::new(first.axes.clone(), values, first.metadata.clone()))
}

/// Checks that the shards are all parts of one table.
fn check(shards: &[NamedShard]) -> Result<(), DatabaseError> {
    let refused = |what: String| Err(DatabaseError::Shards { what });
    let Some(NamedShard { name: first_name, shard: first }) = shards.first() else {
        return refused("there are none".to_owned());
    };
    let mut holders: Vec<Option<&String>> = vec![None; first.part.of];
    for NamedShard { name, shard } in shards {
        let why = if shard.part.of != first.part.of {
            "has another number of parts than"
        } else if shard.axes != first.axes {
            "has other axes than"
        } else if shard.metadata != first.metadata {
            "was filled with other options than"
        } else if shard.arithmetic != first.arithmetic {
            "was filled by another kind of processor or C library than"
        } else if shard.values.errors.is_some() != first.values.errors.is_some() {
            "has other variables than"
        } else {
            ""
        };
        if !why.is_empty() {
            return refused(format!("{name} {why} {first_name}"));
        }
        if let Some(other) = holders[shard.part.number - 1].replace(name) {
            return refused(format!("{other} and {name} are both part {}", shard.part));
        }
    }
    let missing: Vec<String> =
        (0..holders.len()).filter(|i| holders[*i].is_none()).map(|i| (i + 1).to_string()).collect();
    if !missing.is_empty() {
        return refused(format!("of {} parts these are missing: {}", holders.len(), missing.join(", ")));
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn math_fingerprint_is_repeatable() {
        assert_eq!((math_fingerprint(), math_fingerprint().len()), (math_fingerprint(), 16));
    }

    #[test]
    fn every_grain_is_in_one_part() {
        let axes = Axes::paper();
        for of in [1, 2, 7, 45] {
            let mut grains: Vec<usize> = (1..=of).flat_map(|number| Part { number, of }.grains(&axes)).collect();
            grains.sort_unstable();
            assert_eq!(grains, (0..45).collect::<Vec<_>>());
        }
        // Part 2 of 5 holds the nine sizes of the second facetness.
        assert!(Part { number: 2, of: 5 }.grains(&axes).iter().all(|grain| grain % 5 == 1));
        assert!(Part { number: 0, of: 5 }.check(&axes).is_err() && Part { number: 1, of: 46 }.check(&axes).is_err());
        assert_eq!("3/8".parse(), Ok(Part { number: 3, of: 8 }));
        assert!("3".parse::<Part>().is_err());
    }
}
