//! The snowblue command.
fn main() {}
