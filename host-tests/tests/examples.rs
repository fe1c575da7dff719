//! The examples for boards build without a warning, their loops hold what the edge path promises, and they are as large as the firmware page
//! says.
#![allow(missing_docs)]

use std::fs;
use std::time::Instant;

use quadcal_host_tests::firmware::{EXAMPLES, build_example, offences, reachable, size, workspace};

/// Cells of an example's row in the firmware page: package, chip, what it shows, text, data and bss.
fn row(name: &str) -> Vec<String> {
    let page = fs::read_to_string(workspace().join("docs/firmware.md")).unwrap();
    let row = page
        .lines()
        .find(|line| line.starts_with(&format!("| `{name}` |")));
    let cells = row.unwrap_or_default().split('|').map(str::trim);
    cells
        .map(str::to_owned)
        .filter(|cell| !cell.is_empty())
        .collect()
}

#[test]
fn every_folder_is_an_example_that_is_built() {
    let entries = fs::read_dir(workspace().join("examples")).unwrap();
    let mut folders: Vec<_> = entries
        .flatten()
        .filter(|entry| entry.path().join("Cargo.toml").is_file())
        .map(|entry| entry.file_name().into_string().unwrap())
        .collect();
    folders.sort();
    assert_eq!(folders, EXAMPLES.map(|example| example.name));
}

#[test]
fn examples_build_and_their_loops_have_no_panic_no_division_and_no_float() {
    for example in &EXAMPLES {
        let begun = Instant::now();
        let (elf, log) = build_example(example).unwrap_or_else(|error| panic!("{error}"));
        assert!(!log.contains("warning:"), "{log}");
        let size = size(&elf).unwrap_or_else(|error| panic!("{error}"));
        let seconds = begun.elapsed().as_secs();
        println!("{}: {size:?}, {seconds} s", example.name);
        for name in example.loops {
            let functions = reachable(&elf, name).unwrap_or_else(|error| panic!("{error}"));
            let instructions: usize = functions.iter().map(|f| f.instructions.len()).sum();
            assert!(instructions > 300, "{name}: {instructions}");
            assert_eq!(offences(&functions), [], "{}: {name}", example.name);
        }
        let figures: Vec<u64> = row(example.name)
            .iter()
            .filter_map(|cell| cell.parse().ok())
            .collect();
        let [text, ram] = figures[..] else {
            panic!("{}: {figures:?}", example.name)
        };
        // Compilers differ a little.
        assert!(size.text <= text + text / 50, "{}: {size:?}", example.name);
        assert!(
            size.data + size.bss <= ram + ram / 50,
            "{}: {size:?}",
            example.name
        );
    }
}
