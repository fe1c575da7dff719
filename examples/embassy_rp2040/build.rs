//! What the linker needs besides `-Tlink.x`, which the repository's `.cargo/config.toml` gives: this folder's `memory.x`, and where
//! embassy-rp puts the chip's second boot stage.

fn main() {
    let folder = std::env::var("CARGO_MANIFEST_DIR").unwrap_or_default();
    println!("cargo::rerun-if-changed=memory.x");
    println!("cargo::rustc-link-search={folder}");
    println!("cargo::rustc-link-arg-bins=-Tlink-rp.x");
}
