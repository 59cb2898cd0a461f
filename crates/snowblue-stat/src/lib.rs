//! Statistical tests for Monte Carlo results. Used only in tests of the other crates.
//!
//! [`Moments`] accumulates samples. The p-value of a statistic ([`z_p_value`], [`t_p_value`], [`chi_squared_p_value`])
//! is the probability of a deviation at least as large under the null hypothesis. A family of tests fails if any
//! p-value is below [`sidak_level`]:
//!
//! ```
//! use snowblue_stat::{Moments, sidak_level, t_p_value};
//!
//! let mut moments = Moments::default();
//! for sample in [0.9, 1.2, 1.0, 0.8, 1.1] {
//!     moments.push(sample);
//! }
//! let t = (moments.mean() - 1.0) / moments.standard_error();
//! assert!(t_p_value(t, moments.count() as f64 - 1.0) > sidak_level(0.01, 10));
//! ```
//!
//! **Accuracy.** 11 digits up to a thousand degrees of freedom, 8 up to a million.
//!
//! **Out of scope.** Quantiles, one-sided and exact tests, the choice of bins.

pub mod moments;
pub mod p_value;

pub use moments::Moments;
pub use p_value::{chi_squared_p_value, sidak_level, t_p_value, z_p_value};
