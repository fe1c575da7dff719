//! The core on every processor that it is made for: it builds, it gives the same bytes in QEMU as on the host, and it takes no more flash
//! than the firmware page says.

use std::path::Path;
use std::time::Duration;

use quadcal::replay::TimerWidth;
use quadcal::replay::corrected::CorrectedFile;
use quadcal::slot::Slot;
use quadcal_host_tests::firmware::{
    TARGETS, Target, build_core, build_for, run_qemu_on, sizes, workspace,
};
use quadcal_host_tests::rig::Rig;
use quadcal_host_tests::session;

const LIMIT: Duration = Duration::from_secs(60);

/// RAM of the smallest machine, and of one that also learns.
const RAM: [u64; 2] = [16 << 10, 128 << 10];

fn machines() -> impl Iterator<Item = &'static Target> {
    TARGETS.iter().filter(|target| target.machine.is_some())
}

/// Runs an image in a folder and checks the RAM that it took.
fn run(target: &Target, image: &str, args: &[&str], folder: &Path, ram: u64) {
    let elf = build_for(target, image, &[]).unwrap_or_else(|error| panic!("{error}"));
    let output = run_qemu_on(target, &elf, args, folder, LIMIT);
    let output = output.unwrap_or_else(|error| panic!("{}: {error}", target.processor));
    assert!(output.success, "{}: {}", target.processor, output.stderr);
    println!("{}: {image}: {}", target.processor, output.stdout.trim());
    let taken: Option<u64> = ["stack_bytes", "static_bytes"]
        .into_iter()
        .map(|key| output.value(key))
        .sum();
    assert!(
        taken.is_some_and(|taken| (1000..ram).contains(&taken)),
        "{taken:?}"
    );
}

#[test]
fn the_core_builds_with_all_its_features() {
    for target in &TARGETS {
        build_core(target).unwrap_or_else(|error| panic!("{error}"));
    }
}

#[test]
fn every_processor_corrects_and_all_but_the_smallest_learn_to_the_same_bytes_as_the_host() {
    for (timer, seed) in [(TimerWidth::Bits16, 7), (TimerWidth::Bits32, 8)] {
        let rig = Rig {
            lines: 360,
            timer,
            turns: 8,
            seed,
        };
        let events = rig.run().unwrap().file();
        let host = session::run(&events).unwrap();
        let slot = Slot::parse(&host.slot).unwrap();
        let corrected = session::correct(&events, &slot).unwrap();
        let edges = CorrectedFile::parse(&corrected).unwrap().edges().len();
        assert!(edges > 4 * 360 * 20, "{edges} edges");
        for target in machines() {
            let folder = tempfile::tempdir().unwrap();
            let file = |name: &str| folder.path().join(name);
            std::fs::write(file("events"), &events).unwrap();
            std::fs::write(file("slot"), &host.slot).unwrap();
            let arguments = ["events", "slot", "corrected"];
            run(target, "qemu_correct", &arguments, folder.path(), RAM[0]);
            let same = std::fs::read(file("corrected")).unwrap() == corrected;
            assert!(same, "{}: corrected edges differ", target.processor);
            // The microbit has 16 KiB of RAM.
            if target.machine == Some("microbit") {
                continue;
            }
            let arguments = ["events", "learned", "rest"];
            run(target, "qemu_replay_360", &arguments, folder.path(), RAM[1]);
            let same = std::fs::read(file("learned")).unwrap() == host.slot
                && std::fs::read(file("rest")).unwrap() == host.corrected;
            assert!(same, "{}: what was learned differs", target.processor);
        }
    }
}

/// The numbers of a target's row in the firmware page's table of sizes.
fn figures(target: &Target) -> Vec<u64> {
    let page = std::fs::read_to_string(workspace().join("docs/firmware.md")).unwrap();
    let named = format!("`{}`", target.triple);
    let row = page.lines().find(|line| line.contains(&named));
    let cells = row.unwrap_or_default().split('|').map(str::trim);
    cells.filter_map(|cell| cell.parse().ok()).collect()
}

#[test]
fn no_processor_takes_more_flash_than_the_firmware_page_says() {
    for target in &TARGETS {
        let found = sizes(target).unwrap_or_else(|error| panic!("{error}"));
        let found = [found.correct, found.learn].map(|flash| [flash.text, flash.rodata]);
        let figures = figures(target);
        println!("{}: {found:?}, figures {figures:?}", target.processor);
        assert_eq!(figures.len(), 4, "{}", target.processor);
        for (found, figure) in found.as_flattened().iter().zip(figures) {
            // Compilers differ a little.
            assert!(
                *found <= figure + figure / 50,
                "{}: {found}",
                target.processor
            );
        }
    }
}
