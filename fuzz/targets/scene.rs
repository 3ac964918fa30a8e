//! Reads any bytes as a scene file: a scene, or an error that names the file in plain lines.
#![no_main]

use std::path::Path;

libfuzzer_sys::fuzz_target!(|bytes: &[u8]| {
    let Ok(text) = std::str::from_utf8(bytes) else { return };
    if let Err(error) = wetcor::scene::parse(text, Path::new("scene.toml"), String::new()) {
        wetcor_fuzz::assert_told(&error, "scene.toml");
    }
});
