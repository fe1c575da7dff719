//! The header is the one that the crate makes; what C would call does what the header says.
#![allow(missing_docs)]

use std::path::Path;

#[test]
fn the_header_is_the_one_that_the_crate_makes() {
    let here = Path::new(env!("CARGO_MANIFEST_DIR"));
    let config = cbindgen::Config::from_file(here.join("cbindgen.toml")).unwrap();
    let mut builder = cbindgen::Builder::new().with_config(config);
    for file in ["status.rs", "encoder.rs", "learner.rs"] {
        builder = builder.with_src(here.join("src").join(file));
    }
    let mut made = Vec::new();
    builder.generate().unwrap().write(&mut made);
    let made = String::from_utf8(made).unwrap();
    let path = here.join("include/quadcal.h");
    if std::env::var_os("QUADCAL_WRITE_HEADER").is_some() {
        std::fs::write(&path, &made).unwrap();
    }
    let kept = std::fs::read_to_string(&path).unwrap();
    assert!(
        kept == made,
        "include/quadcal.h is of another state of the crate; QUADCAL_WRITE_HEADER=1 writes it anew"
    );
}
