//! Tables in the flash of an emulated STM32F405.

use std::time::Duration;

use quadcal::stm32f405::ROOM;
use quadcal_host_tests::firmware::{Output, build, images, loaded, run_qemu, value};
use quadcal_host_tests::power_cut::{self, Act, Command};

const LIMIT: Duration = Duration::from_secs(60);

fn run(image: &str, folder: &std::path::Path, words: &[&str]) -> Output {
    let elf = build(image, &[]).unwrap_or_else(|error| panic!("{error}"));
    run_qemu(&elf, words, folder, LIMIT).unwrap_or_else(|error| panic!("{error}"))
}

fn last_line(output: &Output) -> &str {
    assert!(output.success, "{}", output.stderr);
    output.stdout.lines().last().unwrap()
}

#[test]
fn a_kill_at_any_moment_leaves_the_old_or_the_new_table() {
    let tally = power_cut::run(10, 7).unwrap_or_else(|error| panic!("{error}"));
    println!("{tally}");
    assert_eq!((tally.kills, tally.old + tally.new), (10, 10));
    assert!(tally.half_written + tally.half_erased >= 1, "{tally}");
}

#[test]
fn a_kill_while_rolling_back_or_erasing_leaves_what_counted_or_what_is_to_count() {
    for act in [Act::RollBack, Act::Erase] {
        let tally = power_cut::act(act, 4, 8).unwrap_or_else(|error| panic!("{error}"));
        println!("{tally}");
        assert_eq!((tally.kills, tally.before + tally.after), (4, 4));
    }
}

#[test]
fn a_kill_while_a_command_is_followed_leaves_the_old_or_the_new_table() {
    for command in Command::ALL {
        let tally = power_cut::commanded(command, 4, 9).unwrap_or_else(|error| panic!("{error}"));
        println!("{tally}");
        assert_eq!((tally.kills, tally.before + tally.after), (4, 4));
    }
}

#[test]
fn tables_are_committed_rolled_back_and_erased_and_outlive_a_restart() {
    let folder = tempfile::tempdir().unwrap();
    let say = |words: &[&str]| {
        let output = run("qemu_store", folder.path(), words);
        last_line(&output).to_owned()
    };
    assert_eq!(say(&["f"]), "counts none wear_a=0 wear_b=0");
    let third = say(&["f", "commit", "3"]);
    assert_eq!(third, "counts place=A sequence=2 wear_a=2 wear_b=2");
    assert_eq!(say(&["f"]), third);
    let second = say(&["f", "roll-back"]);
    assert_eq!(second, "counts place=B sequence=1 wear_a=2 wear_b=2");
    assert_eq!(say(&["f"]), second);
    assert_eq!(say(&["f", "erase"]), "counts none wear_a=3 wear_b=3");
    let wrong = run("qemu_store", folder.path(), &["f", "commit"]);
    assert!(!wrong.success && wrong.stderr.contains("usage"));
}

#[test]
fn a_table_damaged_in_the_file_gives_way_to_the_older_one() {
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("f");
    run("qemu_store", folder.path(), &["f", "commit", "2"]);
    let mut bytes = std::fs::read(&file).unwrap();
    bytes[0x1_0000 + 9000] ^= 0x10;
    std::fs::write(&file, bytes).unwrap();
    let output = run("qemu_store", folder.path(), &["f"]);
    assert_eq!(
        last_line(&output),
        "counts place=A sequence=0 wear_a=1 wear_b=2"
    );
}

/// QEMU has no flash controller: reads give zero, and writes go nowhere.
#[test]
fn the_board_s_driver_says_that_there_is_no_controller() {
    let folder = tempfile::tempdir().unwrap();
    let output = run("board_store", folder.path(), &[]);
    assert!(output.stdout.starts_with("counts none"), "{output:?}");
    assert!(!output.success && output.stderr.contains("Deaf"));
}

#[test]
fn no_image_puts_anything_where_the_tables_are() {
    const FLASH: u64 = 0x0800_0000;
    let room = FLASH + u64::from(ROOM.start)..FLASH + u64::from(ROOM.end);
    for image in images().unwrap() {
        let elf = build(&image, &[]).unwrap_or_else(|error| panic!("{error}"));
        let pieces = loaded(&elf).unwrap();
        assert!(pieces.iter().any(|piece| piece.start == FLASH), "{image}");
        for piece in pieces {
            assert!(
                piece.end <= room.start || piece.start >= room.end,
                "{image}: {piece:x?}"
            );
        }
        let mark = |name: &str| value(&elf, name).unwrap();
        assert_eq!(mark("_tables_start"), Some(room.start), "{image}");
        assert_eq!(mark("_tables_end"), Some(room.end), "{image}");
    }
}
