//! Tables committed, rolled back and erased.

extern crate std;

mod cuts;
pub(crate) mod flash;

use super::*;
use crate::shape::{CLASSES_MAX, EncoderShape};
use crate::slot::{Delays, Slot, slot_bytes};
use crate::units::TurnDelta32;
use flash::{Fault, Flash};
use std::vec::Vec;

/// Two places of two sectors each, after a sector that is not ours.
const PLACES: [core::ops::Range<u32>; 2] = [1024..3072, 3072..5120];

fn store<const W: usize>() -> Store<Flash<W, 1024>> {
    store_on(Flash::new(5))
}

fn store_on<const W: usize>(flash: Flash<W, 1024>) -> Store<Flash<W, 1024>> {
    let layout = Layout::new(&flash, PLACES, 10_000).unwrap();
    Store::new(flash, layout)
}

/// Header of a table number `serial`.
pub(crate) fn header(shape: EncoderShape, serial: u64) -> SlotHeader {
    SlotHeader {
        shape,
        shift: 2,
        turns: 11,
        indexed: true,
        standard_error: 3,
        class_standard_error: 1,
        source: 0,
        learned_until: 0,
        class_offsets: [TurnDelta32(5); CLASSES_MAX],
        delays: Delays::NONE,
        stamp: Stamp {
            serial,
            ..Stamp::default()
        },
    }
}

/// Table number `serial` of so many edges.
pub(crate) fn table_of(edges: u32, serial: u64) -> (SlotHeader, Vec<i16>) {
    let header = header(EncoderShape::new(edges, 4).unwrap(), serial);
    let entries = (0..edges as i16).map(|k| k.wrapping_mul(serial as i16 * 77 + 1));
    (header, entries.collect())
}

/// The same, long enough for both sectors of a place.
fn table(serial: u64) -> (SlotHeader, Vec<i16>) {
    table_of(600, serial)
}

fn commit<const W: usize>(
    store: &mut Store<Flash<W, 1024>>,
    serial: u64,
) -> Result<Found, StoreError<Fault>> {
    let (header, entries) = table(serial);
    store.commit(&header, &entries)
}

/// Number of the table that counts, all of whose entries are looked at in place.
fn counting<const W: usize>(store: &mut Store<Flash<W, 1024>>) -> Option<u64> {
    let found = store.newest().unwrap()?;
    let serial = found.header.stamp.serial;
    let bytes = &store.flash.bytes[found.offset as usize..];
    let slot = Slot::parse(bytes).unwrap();
    assert_eq!(slot.header, found.header);
    let (header, entries) = table(serial);
    assert_eq!(slot.header.class_offsets, header.class_offsets);
    let mapped = slot.angles().unwrap();
    for (edge, entry) in (0..).zip(entries) {
        assert_eq!(
            mapped.error(edge, true),
            TurnDelta32(5 + (i32::from(entry) << 2))
        );
    }
    Some(serial)
}

#[test]
fn the_newest_table_counts_and_rolling_back_gives_the_one_before() {
    let mut store = store::<4>();
    assert_eq!(counting(&mut store), None);
    assert_eq!(store.roll_back(), Err(StoreError::NothingOlder));
    for serial in 1..=5 {
        let found = commit(&mut store, serial).unwrap();
        assert_eq!(found.header.stamp.sequence, serial as u32 - 1);
        assert_eq!(counting(&mut store), Some(serial));
    }
    let older = store.roll_back().unwrap();
    assert_eq!(older.header.stamp.serial, 4);
    assert_eq!(counting(&mut store), Some(4));
    assert_eq!(store.roll_back(), Err(StoreError::NothingOlder));
    assert_eq!(counting(&mut store), Some(4));
    commit(&mut store, 6).unwrap();
    assert_eq!(counting(&mut store), Some(6));
    store.erase().unwrap();
    assert_eq!(counting(&mut store), None);
    for place in [Place::A, Place::B] {
        assert_eq!(store.condition(place).unwrap(), Condition::Unfinished);
    }
    // Six commits and the erasure; a place without a count takes the other's.
    assert_eq!(
        [Place::A, Place::B].map(|place| store.wear(place).unwrap()),
        [5, 4]
    );
}

#[test]
fn a_place_already_withdrawn_is_erased_without_writing_its_mark_again() {
    let mut store = store::<4>();
    commit(&mut store, 1).unwrap();
    commit(&mut store, 2).unwrap();
    store.roll_back().unwrap();
    store.erase().unwrap();
    assert_eq!(counting(&mut store), None);
}

#[test]
fn sequences_go_on_past_their_largest_number() {
    let mut store = store::<4>();
    commit(&mut store, 1).unwrap();
    assert!(later(0, u32::MAX) && later(5, u32::MAX - 5) && !later(u32::MAX, 0) && !later(3, 3));
}

#[test]
fn a_single_bit_flipped_anywhere_takes_the_table_out_of_use() {
    let mut store = store::<4>();
    commit(&mut store, 1).unwrap();
    commit(&mut store, 2).unwrap();
    let newest = store.newest().unwrap().unwrap();
    let length = place_bytes(newest.header.shape);
    assert_eq!(
        length as usize,
        96 + slot_bytes(newest.header.shape).next_multiple_of(32)
    );
    let start = store.layout.of(newest.place).start as usize;
    let used = 96 + slot_bytes(newest.header.shape);
    for byte in 0..used {
        // Wear, and what fills up its mark, do not belong to the table.
        if (64..96).contains(&byte) {
            continue;
        }
        for bit in 0..8 {
            store.flash.bytes[start + byte] ^= 1 << bit;
            assert_eq!(
                store.newest().unwrap().unwrap().header.stamp.serial,
                1,
                "{byte} {bit}"
            );
            store.flash.bytes[start + byte] ^= 1 << bit;
        }
    }
    assert_eq!(counting(&mut store), Some(2));
}

#[test]
fn a_place_erased_too_often_is_not_used() {
    let flash = Flash::<4, 1024>::new(5);
    let layout = Layout::new(&flash, PLACES, 3).unwrap();
    let mut store = Store::new(flash, layout);
    for serial in 1..=5 {
        commit(&mut store, serial).unwrap();
    }
    assert_eq!(
        commit(&mut store, 6),
        Err(StoreError::WornOut { erased: 3 })
    );
    assert_eq!(counting(&mut store), Some(5));
}

#[test]
fn a_table_too_long_for_its_place_is_refused_and_nothing_is_touched() {
    let mut store = store::<4>();
    commit(&mut store, 1).unwrap();
    let before = store.flash.bytes.clone();
    let (header, _) = table(2);
    let long = SlotHeader {
        shape: EncoderShape::new(2400, 4).unwrap(),
        ..header
    };
    assert!(matches!(
        store.commit(&long, &[0_i16; 2400]),
        Err(StoreError::TooLong { room: 2048, .. })
    ));
    assert_eq!(store.flash.bytes, before);
}

#[test]
fn the_room_of_a_slot_has_neither_marks_nor_the_other_place_in_it() {
    let mut store = store::<4>();
    for serial in 1..=2 {
        let found = commit(&mut store, serial).unwrap();
        let room = store.layout.slot_room(found.offset).unwrap();
        let place = PLACES[found.place as usize].clone();
        assert_eq!(room, place.start + 96..place.end);
        let bytes = &store.flash.bytes[room.start as usize..room.end as usize];
        assert_eq!(Slot::parse(bytes).unwrap().header, found.header);
        for other in [room.start - 1, room.start + 1, place.start, room.end] {
            assert_eq!(store.layout.slot_room(other), None);
        }
    }
}

#[test]
fn places_that_cannot_be_are_refused() {
    let flash = Flash::<4, 1024>::new(5);
    let new = |places| Layout::new(&flash, places, 1).unwrap_err();
    assert_eq!(
        new([0..1000, 1024..2048]),
        LayoutError::Unaligned {
            place: 0,
            erase: 1024
        }
    );
    assert_eq!(
        new([0..1024, 2048..2048]),
        LayoutError::Unaligned {
            place: 1,
            erase: 1024
        }
    );
    assert_eq!(
        new([0..1024, 4096..6144]),
        LayoutError::Outside {
            place: 1,
            capacity: 5120
        }
    );
    assert_eq!(new([0..2048, 1024..3072]), LayoutError::Overlap);
    let coarse = Flash::<64, 1024>::new(5);
    assert_eq!(
        Layout::new(&coarse, [0..1024, 1024..2048], 1),
        Err(LayoutError::Pieces { read: 1, write: 64 })
    );
}
