//! The image for a board that learns by command: what it does where no edge comes, in QEMU.
#![allow(missing_docs)]

use quadcal::recalibrate::{Options, Stage};
use quadcal::wire::Request;
use quadcal_host_tests::field_trial::drive::Drive;
use quadcal_host_tests::firmware::{build, size};

/// RAM of the chip without the core-coupled one, and what memory/stm32f405.x keeps of it for the stack.
const RAM: u64 = 128 << 10;
const STACK: u64 = 40 << 10;

#[test]
fn it_serves_its_port_and_opens_no_session_where_there_are_no_random_numbers() {
    let elf = build("drive_f405", &[]).unwrap_or_else(|error| panic!("{error}"));
    let size = size(&elf).unwrap();
    println!("{size:?}");
    assert!(size.data + size.bss <= RAM - STACK, "{size:?}");
    let folder = tempfile::tempdir().unwrap();
    let mut drive = Drive::start(&elf, folder.path(), None).unwrap();
    let mut host = drive.connect().unwrap();
    let identity = host.identify().unwrap();
    assert_eq!((identity.edges, identity.serial), (10_000, 405));
    assert_eq!(identity.clock_hz, 16_000_000);
    let status = host.status().unwrap();
    assert_eq!((status.stage, status.table), (Stage::Idle, None));
    // No edge comes, and time goes on.
    let [before, after] = [host.live().unwrap(), host.live().unwrap()];
    assert!(after.ticks > before.ticks, "{before:?} {after:?}");
    assert_eq!((after.speed, after.faults), (0, [0; 7]));
    // QEMU has no generator of random numbers, and without one the drive lets nobody change it.
    let refused = host.change("start", &Request::Start(Options::default()));
    let refused = refused.unwrap_err().to_string();
    assert!(refused.contains("no random numbers"), "{refused}");
}
