//! Holds the committed header equal to what cbindgen makes of the source.

use std::path::Path;

/// The header of the library as it stands.
fn made() -> String {
    let here = Path::new(env!("CARGO_MANIFEST_DIR"));
    let config = cbindgen::Config::from_file(here.join("cbindgen.toml")).expect("a configuration");
    let source = here.join("src/lib.rs");
    let bindings = cbindgen::Builder::new().with_config(config).with_src(source).generate();
    let mut text = vec![];
    bindings.expect("cbindgen understands the source").write(&mut text);
    String::from_utf8(text).expect("plain text")
}

#[test]
fn the_header_is_the_one_of_the_source() {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("include/wetcor.h");
    let made = made();
    if std::env::var_os("UPDATE_EXPECTED").is_some() {
        std::fs::write(&path, &made).expect("the header can be written");
    }
    let kept = std::fs::read_to_string(&path).unwrap_or_default();
    assert!(
        made == kept,
        "include/wetcor.h is not the header of src/lib.rs: UPDATE_EXPECTED=1 writes it"
    );
    let functions = kept.matches("wetcor_status wetcor_").count() + kept.matches("const char *wetcor_").count();
    let exported = std::fs::read_to_string(Path::new(env!("CARGO_MANIFEST_DIR")).join("src/lib.rs"));
    let exported = exported.expect("the source").matches("#[no_mangle]").count();
    assert_eq!(functions, exported, "a function is missing from the header");
}
