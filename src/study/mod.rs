//! Asks of the whole inference whether it means what it says.
//!
//! | file | job |
//! |---|---|
//! | `calibration.rs` | measures how often intervals cover the truth |

pub mod calibration;
