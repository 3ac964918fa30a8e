//! Asks of the whole inference whether it means what it says.
//!
//! | file | job |
//! |---|---|
//! | `trade/` | measures what each method for the parameters costs and how far off it is |
//! | `calibration.rs` | measures how often intervals cover the truth |

pub mod calibration;
pub mod trade;
