//! Statistics for tests of random engines: does this noisy answer agree with that one?
//!
//! [`Moments`] gathers samples. The p-value of a statistic ([`z_p_value`], [`t_p_value`], [`chi_squared_p_value`]) is the
//! probability of at least as large a deviation if nothing is wrong. A family of tests fails when one p-value lies below
//! [`sidak_level`].
//!
//! **Simplified.** Accuracy is 11 digits up to a thousand degrees of freedom, 8 up to a million.
//! **Out of scope.** Quantiles, one-sided and exact tests, the choice of bins. Only for tests: no other room needs it.

mod special;

pub mod moments;
pub mod p_value;

pub use moments::Moments;
pub use p_value::{chi_squared_p_value, sidak_level, t_p_value, z_p_value};
