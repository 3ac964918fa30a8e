//! Puts draws on disk, for ArviZ as a Zarr store and for R as a table; knows nothing of what was drawn.
//!
//! | file | job |
//! |---|---|
//! | `zarr.rs` | lays groups of arrays out as a Zarr store |
//! | `csv.rs` | writes one line a draw |

pub mod csv;
pub mod zarr;
