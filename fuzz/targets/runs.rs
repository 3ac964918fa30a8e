//! Reads any bytes as a table of runs, twice: as it is, and with the header in quotes, which is cut another way; and drafts
//! a scene from them.
#![no_main]

use wetcor_fuzz::{assert_drafted, assert_told, outcome, Place};

libfuzzer_sys::fuzz_target!(|bytes: &[u8]| {
    let place = Place::with(wetcor_fuzz::SCENE, "runs.csv");
    let plain = place.read(bytes);
    if let Err(error) = &plain {
        assert_told(error, "runs.csv");
    }
    // a quoted column name that is plain otherwise changes nothing
    if let Some(rest) = bytes.strip_prefix(b"particle,") {
        let quoted = place.read(&[b"\"particle\",", rest].concat());
        assert_eq!(outcome(&plain), outcome(&quoted));
    }
    assert_drafted(&place.scene.data.runs[0]);
});
