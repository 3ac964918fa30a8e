//! Reads any bytes as a workbook of runs, and drafts a scene from them.
#![no_main]

use wetcor_fuzz::{assert_drafted, assert_told, Place};

libfuzzer_sys::fuzz_target!(|bytes: &[u8]| {
    let place = Place::with(wetcor_fuzz::SCENE, "runs.xlsx");
    if let Err(error) = place.read(bytes) {
        assert_told(&error, "runs.xlsx");
    }
    assert_drafted(&place.scene.data.runs[0]);
});
