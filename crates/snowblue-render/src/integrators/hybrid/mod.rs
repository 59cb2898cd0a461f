//! Snow by random walks that end in the light field inside.

mod tangent_half_space;
pub(super) mod walk;
