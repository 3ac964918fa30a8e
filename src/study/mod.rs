//! Asks of the whole inference whether it means what it says.
//!
//! | file | job |
//! |---|---|
//! | `trade/` | measures what each method for the parameters costs and how far off it is |
//! | `coverage.rs` | counts over simulated data sets how often intervals cover the truth |
//! | `main_coverage.rs` | measures how often the main numbers cover the truth |
//! | `calibration.rs` | measures how often intervals cover the truth |

pub mod calibration;
pub mod coverage;
pub mod main_coverage;
pub mod trade;
