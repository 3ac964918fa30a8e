//! Puts draws on disk, for ArviZ as a Zarr store and for R as a table.
//!
//! | file | job |
//! |---|---|
//! | `arrays.rs` | holds named arrays in groups |
//! | `posterior.rs` | gathers the groups of a posterior |
//! | `every_run.rs` | writes the likelihood and a prediction of every run |
//! | `zarr.rs` | lays groups of arrays out as a Zarr store |
//! | `csv.rs` | writes one line a draw |

pub mod arrays;
pub mod csv;
pub mod every_run;
pub mod posterior;
pub mod zarr;
