//! The integration tests of `snowblue-render` in one program.

#![allow(
    clippy::cast_possible_truncation,
    clippy::unwrap_used,
    reason = "tests may panic, and numbers of tests are small"
)]

mod any_snow;
mod bake;
mod brightest;
mod build_after;
mod compositing;
mod depth;
mod exposure;
mod furnace;
mod golden;
mod landscapes;
mod lens;
mod light_at_depth;
mod light_field;
mod light_in_layers;
mod lightmap;
mod lights;
mod materials;
mod mesh_formats;
mod parts;
mod places;
mod progress;
mod reference;
mod relief;
mod same_bits;
mod scene_errors;
mod self_shadow;
mod sky;
mod slab_light;
mod snow;
mod snow_block;
mod snow_layers;
mod solids;
mod sparkle;
mod transparent;
mod truth;
