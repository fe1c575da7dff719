//! The driver's sequences against a model of the flash interface, with every fault.

extern crate std;

mod model;
mod store;

use embedded_storage::nor_flash::{NorFlash, ReadNorFlash};

use super::interface::{access, control, key, status};
use super::*;
use model::{Fault, Model};

/// A core so slow that a millisecond is one look at the status register.
const CORE_HZ: u32 = 4000;

fn flash_on(model: Model, supply: Supply) -> Flash<Model> {
    Flash::new(model, ROOM, supply, CORE_HZ)
}

fn flash() -> Flash<Model> {
    flash_on(Model::new(), Supply::From2V7)
}

/// What the driver left behind is in order: nothing forbidden was done, the controller is locked, the caches are on.
fn in_order(flash: &mut Flash<Model>) {
    let model = flash.interface();
    assert_eq!(model.misuse, [""; 0]);
    assert!(model.locked());
    assert_eq!(model.acr, access::DCEN | access::ICEN | 5);
}

fn read<const N: usize>(flash: &mut Flash<Model>, at: u32) -> [u8; N] {
    let mut bytes = [0; N];
    flash.read(at, &mut bytes).unwrap();
    bytes
}

#[test]
fn sectors_are_those_of_the_manual() {
    let sizes = [16, 16, 16, 16, 64, 128, 128, 128, 128, 128, 128, 128];
    let mut start = 0;
    for (sector, size) in (0..).zip(sizes) {
        assert_eq!(sector_start(sector), start);
        let end = start + (size << 10);
        assert_eq!([sector_at(start), sector_at(end - 1)], [sector; 2]);
        assert!(is_border(start) && !is_border(start + 4) && !is_border(end - 4));
        start = end;
    }
    assert_eq!(start, CAPACITY);
    assert!(is_border(CAPACITY) && !is_border(CAPACITY + 4));
    assert!(!is_border(sector_start(4) + (16 << 10)));
}

#[test]
fn a_word_is_written_in_as_many_units_as_the_supply_asks_for() {
    for (supply, psize, units) in [
        (Supply::From1V8, 0, 4),
        (Supply::From2V1, 1, 2),
        (Supply::From2V7, 2, 1),
    ] {
        let mut model = Model::new();
        model.psize_max = psize;
        let mut flash = flash_on(model, supply);
        flash.erase(ROOM.start, ROOM.end).unwrap();
        let erasures = flash.interface().operations;
        assert_eq!(erasures, 3);
        flash.write(ROOM.start + 8, b"quadcal!").unwrap();
        assert_eq!(flash.interface().operations - erasures, 2 * units);
        assert_eq!(&read(&mut flash, ROOM.start + 8), b"quadcal!");
        in_order(&mut flash);
    }
}

#[test]
fn an_erasure_is_the_manual_s_sequence() {
    let mut flash = flash();
    flash.erase(sector_start(4), sector_start(5)).unwrap();
    let serving = control::SER | (4 << 3) | (2 << 8);
    let caches = access::DCEN | access::ICEN;
    assert_eq!(
        flash.interface().log,
        [
            (Register::Key, key::FIRST),
            (Register::Key, key::SECOND),
            (Register::Status, status::ERRORS),
            (Register::Control, serving),
            (Register::Control, serving | control::STRT),
            (Register::Control, control::LOCK),
            (Register::Access, 5),
            (Register::Access, 5 | access::DCRST | access::ICRST),
            (Register::Access, 5),
            (Register::Access, 5 | caches),
        ]
    );
}

#[test]
fn an_erasure_leaves_the_neighbours_and_no_stale_cache() {
    let mut model = Model::new();
    model.memory.fill(0);
    let mut flash = flash_on(model, Supply::From2V7);
    let range = PLACES[0].clone();
    assert_eq!(read(&mut flash, range.start), [0; 4]);
    flash.erase(range.start, range.end).unwrap();
    assert_eq!(read(&mut flash, range.start), [0xFF; 4]);
    for (at, byte) in (0..).zip(&flash.interface().memory) {
        assert_eq!(*byte == 0xFF, range.contains(&at), "{at:#x}");
    }
    in_order(&mut flash);
}

#[test]
fn bits_only_fall() {
    let mut flash = flash();
    flash.write(ROOM.start, &[0xF0; 4]).unwrap();
    flash.write(ROOM.start, &[0xCC; 4]).unwrap();
    assert_eq!(read(&mut flash, ROOM.start), [0xC0; 4]);
    in_order(&mut flash);
}

#[test]
fn what_is_not_the_driver_s_is_refused_before_a_register_is_touched() {
    let mut flash = flash();
    let (start, end) = (ROOM.start, ROOM.end);
    let half = sector_start(4) + (32 << 10);
    for (from, to, error) in [
        (0, start, FlashError::NotOurs),
        (start, sector_start(6), FlashError::NotOurs),
        (start, CAPACITY + (16 << 10), FlashError::OutOfBounds),
        (end, start, FlashError::OutOfBounds),
        (sector_start(4), half, FlashError::NotAligned),
        (half, end, FlashError::NotAligned),
        (start + 4, end, FlashError::NotAligned),
    ] {
        assert_eq!(flash.erase(from, to), Err(error), "{from:#x} {to:#x}");
    }
    for (at, length, error) in [
        (start - 4, 4, FlashError::NotOurs),
        (end - 4, 8, FlashError::NotOurs),
        (CAPACITY - 4, 8, FlashError::OutOfBounds),
        (u32::MAX - 3, 8, FlashError::OutOfBounds),
        (start + 2, 4, FlashError::NotAligned),
        (start, 6, FlashError::NotAligned),
    ] {
        let bytes = &[0; 8][..length];
        assert_eq!(flash.write(at, bytes), Err(error), "{at:#x} {length}");
    }
    let mut two = [0; 2];
    assert_eq!(
        flash.read(CAPACITY - 1, &mut two),
        Err(FlashError::OutOfBounds)
    );
    assert!(flash.interface().log.is_empty());
}

#[test]
fn flags_left_by_others_do_not_count() {
    let mut model = Model::new();
    model.sr = status::PGSERR | status::PGPERR;
    let mut flash = flash_on(model, Supply::From2V7);
    flash.write(ROOM.start, &[0; 4]).unwrap();
    in_order(&mut flash);
}

#[test]
fn a_wrong_key_shuts_the_controller_until_reset() {
    let mut model = Model::new();
    model.write(Register::Key, 1);
    model.misuse.clear();
    let mut flash = flash_on(model, Supply::From2V7);
    let write = |flash: &mut Flash<Model>| flash.write(ROOM.start, &[0; 4]);
    assert_eq!(write(&mut flash), Err(FlashError::Locked));
    // Each further key would be a bus error.
    let errors = flash.interface().misuse.len();
    assert_eq!(write(&mut flash), Err(FlashError::Locked));
    assert_eq!(flash.interface().misuse.len(), errors);
    assert_eq!(read(&mut flash, ROOM.start), [0xFF; 4]);
    let mut model = flash.into_interface();
    model.restart();
    let mut flash = flash_on(model, Supply::From2V7);
    write(&mut flash).unwrap();
    in_order(&mut flash);
}

#[test]
fn a_controller_that_keeps_no_command_is_not_started() {
    let mut model = Model::new();
    model.deaf = true;
    let mut flash = flash_on(model, Supply::From2V7);
    assert_eq!(
        flash.erase(ROOM.start, ROOM.end),
        Err(FlashError::Deaf),
        "erase"
    );
    assert_eq!(flash.write(ROOM.start, &[0; 4]), Err(FlashError::Deaf));
    assert_eq!(flash.interface().operations, 0);
}

#[test]
fn every_error_flag_has_its_name_and_ends_the_operation() {
    for (flag, why) in [
        (status::WRPERR, Refusal::WriteProtected),
        (status::PGSERR, Refusal::Sequence),
        (status::PGPERR, Refusal::Parallelism),
        (status::PGAERR, Refusal::Alignment),
        (status::OPERR, Refusal::Operation),
    ] {
        let mut flash = flash();
        flash.interface().fault = Some((1, Fault::Flags(flag)));
        let at = ROOM.start + 4;
        assert_eq!(
            flash.write(ROOM.start, &[0x55; 12]),
            Err(FlashError::Refused { at, why })
        );
        assert_eq!(read(&mut flash, at), [0xFF; 8]);
        in_order(&mut flash);

        flash.interface().fault = Some((3, Fault::Flags(flag)));
        let at = sector_start(3);
        assert_eq!(
            flash.erase(ROOM.start, ROOM.end),
            Err(FlashError::Refused { at, why })
        );
        // What was erased before is read as it is now, and the flag does not outlive the operation.
        assert_eq!(read(&mut flash, ROOM.start), [0xFF; 4]);
        in_order(&mut flash);
        flash.write(ROOM.start, &[1; 4]).unwrap();
        in_order(&mut flash);
    }
}

#[test]
fn a_protected_sector_is_named() {
    let mut flash = flash();
    flash.interface().protected = 1 << 4;
    let at = sector_start(4);
    let refused = Err(FlashError::Refused {
        at,
        why: Refusal::WriteProtected,
    });
    assert_eq!(flash.erase(ROOM.start, ROOM.end), refused);
    assert_eq!(flash.write(at, &[0; 4]), refused);
    in_order(&mut flash);
}

#[test]
fn a_word_that_does_not_take_is_found() {
    let mut flash = flash();
    flash.interface().fault = Some((1, Fault::Weak));
    assert_eq!(
        flash.write(ROOM.start, &[0; 12]),
        Err(FlashError::Mismatch(ROOM.start + 4))
    );
    in_order(&mut flash);
}

#[test]
fn a_slow_operation_is_waited_for_up_to_its_limit_and_not_beyond() {
    let erase = |flash: &mut Flash<Model>| flash.erase(sector_start(2), sector_start(3));
    let mut patient = flash();
    patient.interface().fault = Some((0, Fault::Slow(500)));
    erase(&mut patient).unwrap();
    in_order(&mut patient);

    let mut flash = flash();
    flash.interface().memory.fill(0);
    assert_eq!(read(&mut flash, sector_start(2)), [0; 4]);
    flash.interface().fault = Some((0, Fault::Slow(501 + 1000)));
    assert_eq!(erase(&mut flash), Err(FlashError::Timeout));
    // The operation is still running: the bus must not be stalled, and what is read next is what the erasure left.
    assert_eq!(read(&mut flash, sector_start(2)), [0xFF; 4]);
    assert_eq!(flash.interface().misuse, [""; 0]);
    erase(&mut flash).unwrap();
    in_order(&mut flash);
}

#[test]
fn a_controller_that_is_busy_for_ever_stalls_nothing() {
    let mut flash = flash();
    flash.interface().fault = Some((0, Fault::Slow(u32::MAX)));
    assert_eq!(
        flash.write(ROOM.start, &[0; 8]),
        Err(FlashError::Timeout),
        "write"
    );
    let mut four = [0; 4];
    assert_eq!(flash.read(ROOM.start, &mut four), Err(FlashError::Timeout));
    assert_eq!(
        flash.erase(ROOM.start, ROOM.end),
        Err(FlashError::Timeout),
        "erase"
    );
    assert_eq!(flash.write(ROOM.start, &[0; 4]), Err(FlashError::Timeout));
    assert_eq!(flash.interface().misuse, [""; 0]);
}

#[test]
fn limits_hold_for_the_slowest_supply_and_the_fastest_core() {
    // 4 s of a 128 KiB sector at 168 MHz and four cycles a look still fit the counter.
    let mut model = Model::new();
    model.busy_for = 50_000;
    let mut flash = Flash::new(model, ROOM, Supply::From1V8, 168_000_000);
    flash.erase(ROOM.start, ROOM.end).unwrap();
    in_order(&mut flash);
    assert!(4000 * (168_000_000_u64 / 4000) < u64::from(u32::MAX));
}
