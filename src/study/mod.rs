//! Asks of the whole inference whether it means what it says.
//!
//! | file | job |
//! |---|---|
//! | `accuracy.rs` | measures how often an accuracy that was asked for is kept |
//! | `trade/` | measures what each way to the parameters costs and how far off it is |
//! | `calibration.rs` | measures how often intervals cover the truth |

pub mod accuracy;
pub mod calibration;
pub mod trade;
