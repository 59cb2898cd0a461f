//! The scene files that figures render, and the lines of them that figures change.

pub(crate) const LAMP: &str = include_str!("../scenes/fig1_lamp.toml");
pub(crate) const BLOCK_FRONT: &str = include_str!("../scenes/fig9_front.toml");
pub(crate) const BLOCK_BACK: &str = include_str!("../scenes/fig9_back.toml");
pub(crate) const BLOCK_OBLIQUE: &str = include_str!("../scenes/fig9_oblique.toml");
pub(crate) const IGLOO: &str = include_str!("../scenes/fig10_igloo.toml");
pub(crate) const IGLOO_OPAQUE: &str = include_str!("../scenes/fig10_opaque.toml");
pub(crate) const DRAGON: &str = include_str!("../scenes/fig11_dragon.toml");
pub(crate) const BALL: &str = include_str!("../scenes/truth_ball.toml");

/// Size of the blocks.
pub(crate) const BLOCK_SIZE: &str = "size = [0.6, 0.3, 0.6]";
