//! The driver's sequences against a model of the flash interface.

extern crate std;

mod faults;
mod model;
mod store;

use embedded_storage::nor_flash::{NorFlash, ReadNorFlash};

use super::interface::{access, control, key, status};
use super::*;
use model::Model;

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
