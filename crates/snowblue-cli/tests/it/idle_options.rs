//! Options that matter are not refused as without effect.

use crate::shell::{snowblue, stdout};

/// A kind of snow of which one quantity is left, and the seed of the ordinates.
#[test]
fn options_with_effect_are_taken() {
    let with = |options: &str| stdout(&format!("spectrum --wavelengths 500 --thickness 2 {options}"));
    assert_ne!(with("--snow firn --density 300"), with("--density 300"));
    assert_ne!(with("--snow firn --grain-size 400"), with("--grain-size 400"));
    assert_ne!(with("--seed 2"), with(""));
}

#[test]
fn a_path_mode_selects_the_integrator_that_has_it() {
    let picture = |integrator: &str| {
        let small = "--width 6 --height 4 --spp 1 --path view -o -";
        snowblue(&format!("render --scene block_30cm {small} {integrator}")).stdout
    };
    let by_path_mode = picture("");
    assert!(by_path_mode.starts_with(b"\x89PNG") && by_path_mode == picture("--integrator pcasnow"));
}
