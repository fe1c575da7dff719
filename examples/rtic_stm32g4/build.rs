//! Where the linker finds this folder's `memory.x`; `-Tlink.x` is given by the repository's `.cargo/config.toml`.

fn main() {
    let folder = std::env::var("CARGO_MANIFEST_DIR").unwrap_or_default();
    println!("cargo::rerun-if-changed=memory.x");
    println!("cargo::rustc-link-search={folder}");
}
