//! Slots written and read back, damaged, and of every version.

extern crate std;
use super::*;
use crate::edge::Direction;
use crate::shape::CLASSES_MAX;
use crate::units::{TickDelta8, TurnDelta32};
use proptest::prelude::*;
use std::vec::Vec;

const STAMP: Stamp = Stamp {
    serial: 0x0102_0304_0506_0708,
    learned_at: 1_790_000_000,
    temperature_q4: Some(-40),
    sequence: 7,
    table_rms: 98_765,
};

const DELAYS: Delays = Delays {
    of_class: [
        TickDelta8(700),
        TickDelta8(-900),
        TickDelta8(300),
        TickDelta8(-100),
        TickDelta8(0),
        TickDelta8(0),
    ],
    standard_error: 9,
    clock_hz: 84_000_000,
};

fn sample(edges: u32, classes: u32) -> (SlotHeader, Vec<i16>, Vec<u8>) {
    let mut class_offsets = [TurnDelta32(0); CLASSES_MAX];
    class_offsets[0] = TurnDelta32(-77);
    let header = SlotHeader {
        shape: EncoderShape::new(edges, classes).unwrap(),
        shift: 3,
        turns: 11,
        indexed: true,
        standard_error: 1234,
        class_standard_error: 5,
        source: 0x1234_5678,
        learned_until: 0x1_0000_0002,
        class_offsets,
        delays: DELAYS,
        stamp: STAMP,
    };
    let entries: Vec<i16> = (0..edges).map(|k| (k as i16).wrapping_mul(-321)).collect();
    let mut bytes = Vec::new();
    write(&header, &entries, |piece| {
        bytes.extend_from_slice(piece);
        Ok::<(), ()>(())
    })
    .unwrap();
    (header, entries, bytes)
}

#[test]
fn a_slot_read_back_is_the_slot_written() {
    for (edges, classes) in [(12, 6), (9, 1), (10_000, 4)] {
        let (header, entries, mut bytes) = sample(edges, classes);
        assert_eq!(bytes.len(), slot_bytes(header.shape));
        bytes.extend_from_slice(&[0xFF; 7]);
        let slot = Slot::parse(&bytes).unwrap();
        assert_eq!(slot.header, header);
        let back: Vec<i16> = slot.entries.iter().map(|entry| entry.value()).collect();
        assert_eq!(back, entries);
    }
}

#[test]
fn every_single_bit_flip_and_every_cut_is_found() {
    let (_, _, bytes) = sample(12, 6);
    for (_, bytes) in EVERY_VERSION.into_iter().chain([(VERSION, &bytes[..])]) {
        every_flip_and_cut_is_found(bytes);
    }
}

fn every_flip_and_cut_is_found(bytes: &[u8]) {
    for bit in 0..bytes.len() * 8 {
        let mut broken = bytes.to_vec();
        broken[bit / 8] ^= 1 << (bit % 8);
        assert!(Slot::parse(&broken).is_err(), "bit {bit}");
    }
    for length in 0..bytes.len() {
        assert!(
            matches!(
                Slot::parse(&bytes[..length]),
                Err(SlotError::Truncated { .. })
            ),
            "{length}"
        );
    }
}

/// A slot of every version ever written: twelve edges in six classes.
const EVERY_VERSION: [(u16, &[u8]); 3] = [
    (1, include_bytes!("data/version-1.qct")),
    (2, include_bytes!("data/version-2.qct")),
    (3, include_bytes!("data/version-3.qct")),
];

#[test]
fn a_slot_of_every_version_ever_written_is_read() {
    let (newest, entries, bytes) = sample(12, 6);
    for (version, old) in EVERY_VERSION {
        let slot = Slot::parse(old).unwrap();
        let delays = if version < 2 { Delays::NONE } else { DELAYS };
        assert_eq!(
            slot.header,
            SlotHeader {
                delays,
                stamp: if version < 3 { Stamp::default() } else { STAMP },
                ..newest
            },
            "version {version}"
        );
        let table = slot.table_at(84_000_000).unwrap();
        for edge in 0..12 {
            let entry = i32::from(entries[edge as usize]) << 3;
            let offset = if edge % 6 == 0 { -77 } else { 0 };
            assert_eq!(table.error(edge, true), TurnDelta32(offset + entry));
        }
        assert_eq!(table.class_delays(), &delays.of_class);
    }
    assert_eq!(
        EVERY_VERSION.last().map(|(version, _)| *version),
        Some(VERSION)
    );
    assert_eq!(
        EVERY_VERSION.last().map(|(_, old)| *old),
        Some(&bytes[..]),
        "the bytes of a version never change"
    );
}

#[test]
fn a_version_to_come_is_refused_by_name() {
    let (_, _, mut bytes) = sample(12, 6);
    bytes[4] = 4;
    assert_eq!(Slot::parse(&bytes).unwrap_err(), SlotError::Version(4));
}

#[test]
fn what_the_reserved_bytes_will_hold_does_not_disturb_this_reader() {
    let (header, _, mut bytes) = sample(12, 6);
    bytes[128..HEADER_BYTES].fill(0xA5);
    seal(&mut bytes);
    assert_eq!(Slot::parse(&bytes).unwrap().header, header);
}

/// Makes the CRC agree again.
fn seal(bytes: &mut [u8]) {
    let (body, crc) = bytes.split_last_chunk_mut::<4>().unwrap();
    *crc = CRC32.checksum(body).to_le_bytes();
}

#[test]
fn delays_hold_at_the_clock_of_the_device_or_are_refused() {
    let (_, _, mut bytes) = sample(12, 6);
    let slot = Slot::parse(&bytes).unwrap();
    let doubled = slot.table_at(168_000_000).unwrap();
    assert_eq!(doubled.delay(1, Direction::Forward), TickDelta8(-1800));
    for clock_hz in [0, u64::MAX] {
        assert_eq!(
            slot.table_at(clock_hz).unwrap_err(),
            TableError::Clock(clock_hz)
        );
    }
    assert_eq!(
        slot.angles().unwrap().delay(1, Direction::Forward),
        TickDelta8(0)
    );
    // Without a clock in the slot its delays mean nothing.
    bytes[92..100].fill(0);
    seal(&mut bytes);
    assert_eq!(Slot::parse(&bytes).unwrap_err(), SlotError::Clock);
    // A slot without delays holds at any clock.
    bytes[64..88].fill(0);
    seal(&mut bytes);
    assert!(Slot::parse(&bytes).unwrap().table_at(0).is_ok());
}

proptest! {
    #[test]
    fn any_bytes_are_refused_without_panic(
        mut bytes in prop::collection::vec(any::<u8>(), 0..300), magic in any::<bool>(), version in 0..=VERSION
    ) {
        if magic && bytes.len() > 6 {
            bytes[..4].copy_from_slice(&MAGIC);
            bytes[4..6].copy_from_slice(&version.to_le_bytes());
        }
        prop_assert!(Slot::parse(&bytes).is_err());
    }
}

proptest! {
    #[test]
    fn any_header_with_a_clock_comes_back(
        offsets in prop::array::uniform6(any::<i32>()), delays in prop::array::uniform6(any::<i32>()),
        numbers in prop::array::uniform5(any::<u32>()), clock_hz in 1..u64::MAX, learned_until in any::<u64>(), indexed in any::<bool>()
    ) {
        let [turns, standard_error, class_standard_error, source, delay_error] = numbers;
        let header = SlotHeader {
            shape: EncoderShape::new(12, 6).unwrap(),
            shift: 16,
            turns,
            indexed,
            standard_error,
            class_standard_error,
            source,
            learned_until,
            class_offsets: offsets.map(TurnDelta32),
            delays: Delays { of_class: delays.map(TickDelta8), standard_error: delay_error, clock_hz },
            stamp: Stamp { sequence: source, serial: learned_until, ..STAMP },
        };
        let mut bytes = Vec::new();
        write(&header, &[-5_i16; 12], |piece| {
            bytes.extend_from_slice(piece);
            Ok::<(), ()>(())
        }).unwrap();
        prop_assert_eq!(Slot::parse(&bytes).unwrap().header, header);
    }
}
