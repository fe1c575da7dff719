//! Errors and delays of edges, and what a table refuses.

use super::*;
use proptest::prelude::*;
use std::vec;

fn offsets() -> [TurnDelta32; CLASSES_MAX] {
    [
        TurnDelta32(-30),
        TurnDelta32(10),
        TurnDelta32(15),
        TurnDelta32(5),
        TurnDelta32(0),
        TurnDelta32(0),
    ]
}

#[test]
fn before_the_index_only_the_class_is_corrected() {
    let entries = [100, -100, 7, 8, 0, 0, 0, 0];
    let shape = EncoderShape::new(8, 4).unwrap();
    let table = ErrorTable::new(shape, offsets(), &entries, 2).unwrap();
    assert_eq!(table.error(1, false), TurnDelta32(10));
    assert_eq!(table.error(1, true), TurnDelta32(10 - 400));
    assert_eq!(table.angle(2, true), Turn32((1 << 30) - 15 - 28));
    assert_eq!(table.angle(0, true), Turn32(0_u32.wrapping_sub(400 - 30)));
}

#[test]
fn a_delay_belongs_to_the_electrical_edge() {
    let delays = [1, 2, 3, 4, 5, 6].map(TickDelta8);
    let of = |classes: u32| {
        let shape = EncoderShape::new(60, classes).unwrap();
        let table = ErrorTable::new(shape, offsets(), &[0; 60], 0).unwrap();
        let table = table.with_delays(delays);
        let all = |direction| -> std::vec::Vec<i32> {
            (6 * classes..7 * classes)
                .map(|edge| table.delay(edge % 60, direction).0)
                .collect()
        };
        (all(Direction::Forward), all(Direction::Reverse))
    };
    // A rises, B rises, A falls, B falls.
    assert_eq!(of(4), (vec![1, 2, 3, 4], vec![3, 4, 1, 2]));
    assert_eq!(of(6), (vec![1, 2, 3, 4, 5, 6], vec![4, 5, 6, 1, 2, 3]));
    assert_eq!(of(2), (vec![1, 2], vec![2, 1]));
    assert_eq!(of(1), (vec![1], vec![1]));
    assert_eq!(of(3), (vec![1, 2, 3], vec![1, 2, 3]));
}

#[test]
fn a_table_of_another_length_or_scale_is_refused() {
    let shape = EncoderShape::new(8, 4).unwrap();
    assert_eq!(
        ErrorTable::new(shape, offsets(), &[0; 7], 2).unwrap_err(),
        TableError::Length(7)
    );
    assert_eq!(
        ErrorTable::new(shape, offsets(), &[0; 8], 17).unwrap_err(),
        TableError::Shift(17)
    );
}

proptest! {
    #[test]
    fn any_edge_number_is_answered(edge in any::<u32>(), entry in any::<i16>(), shift in 0_u32..=16) {
        let entries = [entry; 12];
        let shape = EncoderShape::new(12, 6).unwrap();
        let table = ErrorTable::new(shape, offsets(), &entries, shift).unwrap();
        let error = table.error(edge, true).0;
        prop_assert!((error - (i32::from(entry) << shift)).abs() <= 30 || edge >= 12);
        prop_assert!(table.error(edge, false).0.abs() <= 30);
    }
}
