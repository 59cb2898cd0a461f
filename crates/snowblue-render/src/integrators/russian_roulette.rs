//! Russian roulette: the only rule by which paths over surfaces end by chance.

use snowblue_scene::spectrum::Spectrum;

/// Bounces before it begins.
const SAFE_BOUNCES: u32 = 4;

/// Probability with which a path of some throughput survives a bounce.
pub(super) fn survival_probability(bounce: u32, throughput: &Spectrum) -> f32 {
    if bounce < SAFE_BOUNCES { 1.0 } else { throughput.maximum().min(1.0) }
}
