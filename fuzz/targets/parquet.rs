//! Reads any bytes as a Parquet table of runs.
#![no_main]

use wetcor_fuzz::{assert_told, Place};

libfuzzer_sys::fuzz_target!(|bytes: &[u8]| {
    if let Err(error) = Place::with(wetcor_fuzz::SCENE, "runs.parquet").read(bytes) {
        assert_told(&error, "runs.parquet");
    }
});
