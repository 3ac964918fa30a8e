//! Reads any bytes as a workbook of runs.
#![no_main]

use wetcor_fuzz::{assert_told, Place};

libfuzzer_sys::fuzz_target!(|bytes: &[u8]| {
    if let Err(error) = Place::with(wetcor_fuzz::SCENE, "runs.xlsx").read(bytes) {
        assert_told(&error, "runs.xlsx");
    }
});
