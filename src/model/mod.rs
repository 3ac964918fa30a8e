//! Holds the model of the runs: the one statement they are drawn from, and the priors of its parameters.
//!
//! | file | job |
//! |---|---|
//! | `parameters.rs` | the parameters a scene's runs call for |
//! | `transforms.rs` | bounded parameters on the whole line |
//! | `likelihood/` | log likelihood of all runs, and of each run |
//! | `series_offsets.rs` | offsets of series on the whole line |
//! | `posterior.rs` | log posterior density and its slopes on the whole line |
//! | `simulate.rs` | draws runs from a truth |

pub mod likelihood;
pub mod parameters;
pub mod posterior;
pub mod series_offsets;
pub mod simulate;
pub mod transforms;
