//! The variables that tests of derivatives go through.

use snowblue_transport::{Property, Substance, Variable};

/// Every variable, of the impurities those whose tables differ most.
pub(crate) fn variables() -> Vec<Variable> {
    const KEPT: [Substance; 5] = [
        Substance::BLACK_CARBON,
        Substance::SAHARAN_DUST,
        Substance::COLORADO_DUST,
        Substance::BROWN_CARBON,
        Substance::SNOW_ALGAE,
    ];
    let is_kept = |by: &Variable| !matches!(by, Variable::Snow(Property::Impurity(one)) if !KEPT.contains(one));
    Variable::all().into_iter().filter(is_kept).collect()
}
