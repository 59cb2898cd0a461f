//! Statistical tests for random engines: z, t, chi-squared, Sidak.
