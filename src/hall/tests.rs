//! Hall states in both directions, lost edges and arbitrary levels.

use super::*;
use proptest::prelude::*;

const STATES: [u8; 6] = [0b100, 0b110, 0b010, 0b011, 0b001, 0b101];

fn at(k: u64) -> Sample {
    Sample {
        ticks: k * 1000,
        levels: Levels(STATES[(k % 6) as usize]),
    }
}

fn running(edges: u64) -> HallDecoder {
    let mut decoder = HallDecoder::new(2).unwrap();
    (0..edges).for_each(|k| {
        decoder.push(at(k));
    });
    decoder
}

#[test]
fn the_forward_order_counts_up_and_the_other_down() {
    let mut decoder = running(14);
    assert_eq!((decoder.position(), decoder.faults().total()), (1, 0));
    let back = Sample {
        ticks: 60_000,
        ..at(12)
    };
    let step = decoder.push(back).step().unwrap();
    assert_eq!((step.edge, step.position, step.interval), (1, 0, 47_000));
    assert_eq!(step.flags, Flags::REVERSED);
}

#[test]
fn one_to_six_lost_edges_are_never_silent() {
    for lost in 1..=6 {
        let mut decoder = running(20);
        decoder.push(at(20 + lost));
        assert!(decoder.is_uncertain(), "{lost} lost");
        let right = (20 + lost) % 12 == u64::from(decoder.position());
        assert!(right || lost > 3, "{lost} lost");
        (21 + lost..34 + lost).for_each(|k| {
            decoder.push(at(k));
        });
        assert!(!decoder.is_uncertain());
    }
}

#[test]
fn an_interval_stretched_by_cogging_is_no_fault() {
    let mut decoder = running(20);
    let stretched = Sample {
        ticks: 19_000 + 3500,
        ..at(20)
    };
    decoder.push(stretched);
    assert_eq!(decoder.faults().total(), 0);
}

#[test]
fn all_sensors_alike_is_counted_and_takes_no_step() {
    let mut decoder = running(20);
    let position = decoder.position();
    for levels in [0, 7] {
        let outcome = decoder.push(Sample {
            ticks: 19_500,
            levels: Levels(levels),
        });
        assert_eq!(outcome, Outcome::Idle);
    }
    assert_eq!(
        (decoder.faults().illegal, decoder.position()),
        (2, position)
    );
    assert!(decoder.is_uncertain());
}

#[test]
fn too_many_pole_pairs_are_refused() {
    assert_eq!(HallDecoder::new(0).unwrap_err(), SensorError::Slots);
    assert_eq!(HallDecoder::new(u32::MAX).unwrap_err(), SensorError::Slots);
}

proptest! {
    #[test]
    fn arbitrary_samples_keep_the_state(rows in prop::collection::vec((0u64..1 << 34, any::<u8>()), 1..300), pairs in 1u32..9) {
        let mut decoder = HallDecoder::new(pairs).unwrap();
        for (ticks, levels) in rows {
            decoder.push(Sample { ticks, levels: Levels(levels) });
            prop_assert!(decoder.position() < 6 * pairs);
            if let Some(state) = state_of(Levels(levels)) {
                prop_assert_eq!(decoder.position() % 6, state);
            }
        }
    }
}
