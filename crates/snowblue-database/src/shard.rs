//! A table in parts, for machines that do not know of each other.
//!
//! Shard i of n holds some of the table's grains (size × facetness): the i-th of n runs of neighbours where the facetness
//! runs slower, since a facetness costs a grain tally. Its values are the table's to the last bit, so that a merged table
//! is the one that a single machine would have filled. Machines whose functions round otherwise are told apart.

use std::fmt;
use std::str::FromStr;

use crate::fill::{self, FillOptions, FillTimes, Values};
use crate::{Axes, DatabaseError, Table};

/// Which part of how many.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Part {
    /// From 1.
    pub number: usize,
    /// How many parts there are.
    pub of: usize,
}

/// Some grains of a table.
#[derive(Debug, Clone, PartialEq)]
pub struct Shard {
    /// Axes of the whole table.
    pub axes: Axes,
    /// Which part this is.
    pub part: Part,
    /// The values of its grains, in the order of [`Part::grains`].
    pub values: Values,
    /// How the table is made, by name.
    pub metadata: Vec<(String, String)>,
    /// [`arithmetic`] of the machine that filled it.
    pub arithmetic: String,
}

/// A fingerprint of the machine's exponentials, logarithms and cosines.
///
/// They come from the system's C library, which has several for different processors: their last bits differ by 10⁻¹³ in a
/// table's values. Shards of different fingerprints make a table, but not the one that either machine would make.
#[must_use]
pub fn arithmetic() -> String {
    let mut hash = 0xcbf2_9ce4_8422_2325_u64;
    for step in 1..=2000 {
        let x = 0.01 * f64::from(step);
        for value in [(-x).exp(), (-x).exp_m1(), x.ln(), x.cos(), x.tanh(), x.powf(0.37)] {
            // FNV-1a (Fowler, Noll & Vo), a double at a time.
            hash = (hash ^ value.to_bits()).wrapping_mul(0x0100_0000_01b3);
        }
    }
    format!("{hash:016x}")
}

impl Part {
    /// The grains of this part; the parts differ by one grain at the most.
    #[must_use]
    pub fn grains(self, axes: &Axes) -> Vec<usize> {
        let (sizes, kinds) = (axes.grain_sizes_um.len(), axes.facetness.len());
        let at = |part: usize| axes.grains() * part / self.of;
        (at(self.number - 1)..at(self.number)).map(|place| (place % sizes) * kinds + place / sizes).collect()
    }

    /// Checks that there is such a part and that it holds something.
    ///
    /// # Errors
    /// [`DatabaseError::Part`] otherwise.
    pub fn check(self, axes: &Axes) -> Result<(), DatabaseError> {
        let grains = axes.grains();
        let there = (1..=self.of).contains(&self.number) && self.of <= grains;
        if there { Ok(()) } else { Err(DatabaseError::Part { number: self.number, of: self.of, grains }) }
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
/// If there is no such part, or an axis or option is out of range.
pub fn fill_part(
    axes: &Axes,
    options: &FillOptions,
    part: Part,
    progress: &(dyn Fn(u64, u64) + Sync),
) -> Result<(Shard, FillTimes), DatabaseError> {
    part.check(axes)?;
    let (values, times) = fill::fill_grains(axes, options, &part.grains(axes), progress)?;
    let metadata = fill::metadata(options);
    Ok((Shard { axes: axes.clone(), part, values, metadata, arithmetic: arithmetic() }, times))
}

/// Puts all parts of a table together. Each shard comes with a name that stands in messages.
///
/// # Errors
/// [`DatabaseError::Shards`] if one is missing, comes twice, or is of another table.
pub fn merge(shards: &[(String, Shard)]) -> Result<Table, DatabaseError> {
    let refused = |what: String| Err(DatabaseError::Shards { what });
    let Some((first_name, first)) = shards.first() else {
        return refused("there are none".to_owned());
    };
    let mut holders: Vec<Option<&String>> = vec![None; first.part.of];
    for (name, shard) in shards {
        let why = match shard {
            shard if shard.part.of != first.part.of => "has another number of parts than",
            shard if shard.axes != first.axes => "has other axes than",
            shard if shard.metadata != first.metadata => "was made in another way than",
            shard if shard.arithmetic != first.arithmetic => {
                "was filled by another kind of processor or C library than"
            }
            shard if shard.values.errors.is_some() != first.values.errors.is_some() => "has other variables than",
            _ => "",
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
    let gathered = |values: &dyn Fn(&Values) -> &[f64]| {
        let per_grain = first.axes.curves() / first.axes.grains() * first.axes.wavelengths_nm.len();
        let mut whole = vec![0.0; first.axes.grains() * per_grain];
        for (_, shard) in shards {
            let blocks = values(&shard.values).chunks_exact(per_grain);
            for (grain, block) in shard.part.grains(&shard.axes).into_iter().zip(blocks) {
                whole[grain * per_grain..][..per_grain].copy_from_slice(block);
            }
        }
        whole
    };
    let error = |quantity: usize| gathered(&|values| values.errors.as_ref().map_or(&[], |errors| &errors[quantity]));
    Ok(Table {
        axes: first.axes.clone(),
        transmittance: gathered(&|values| &values.transmittance),
        reflectance: gathered(&|values| &values.reflectance),
        errors: first.values.errors.is_some().then(|| [error(0), error(1)]),
        metadata: first.metadata.clone(),
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn arithmetic_is_repeatable() {
        assert_eq!((arithmetic(), arithmetic().len()), (arithmetic(), 16));
    }

    #[test]
    fn parts_share_the_grains() {
        let axes = Axes::paper();
        for of in [1, 2, 7, 45] {
            let mut grains: Vec<usize> = (1..=of).flat_map(|number| Part { number, of }.grains(&axes)).collect();
            grains.sort_unstable();
            assert_eq!(grains, (0..45).collect::<Vec<_>>());
        }
        // Nine sizes of one facetness are one part of five.
        assert!(Part { number: 2, of: 5 }.grains(&axes).iter().all(|grain| grain % 5 == 1));
        assert!(Part { number: 0, of: 5 }.check(&axes).is_err() && Part { number: 1, of: 46 }.check(&axes).is_err());
        assert_eq!("3/8".parse(), Ok(Part { number: 3, of: 8 }));
        assert!("3".parse::<Part>().is_err());
    }
}
