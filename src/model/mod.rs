//! Says what we believe of the runs: the one statement they are drawn from.

pub mod simulate;
