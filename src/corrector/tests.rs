//! Corrected angles at edges and between, glitches, and plain steps against any step.

use super::*;
use crate::shape::{CLASSES_MAX, EncoderShape};
use crate::units::TickDelta8;
use proptest::prelude::*;

fn step(edge: u32, ticks: Ticks, direction: Direction) -> Outcome {
    Outcome::Step(Step {
        ticks,
        edge,
        position: edge,
        interval: 1000,
        resync: 0,
        advance: 1,
        flags: Flags::REFERENCED,
        direction,
    })
}

const ENTRIES: [i16; 8] = [0, 1000, 0, -1000, 0, 0, 0, 500];

fn corrector() -> Corrector<'static> {
    let shape = EncoderShape::new(8, 4).unwrap();
    let table = ErrorTable::new(shape, [TurnDelta32(0); CLASSES_MAX], &ENTRIES, 8).unwrap();
    Corrector::new(table, Anchor::Index)
}

#[test]
fn angle_and_way_are_those_of_the_shaft_in_both_directions() {
    let mut corrector = corrector();
    corrector.push(&step(0, 0, Direction::Forward));
    let forward = corrector.push(&step(1, 1000, Direction::Forward)).unwrap();
    assert_eq!(forward.angle, Turn32((1 << 29) - 256_000));
    assert_eq!(forward.moved, TurnDelta32((1 << 29) - 256_000));
    let turned = corrector.push(&step(1, 2000, Direction::Reverse)).unwrap();
    assert_eq!(turned.moved, TurnDelta32(0));
    let back = corrector.push(&step(0, 3000, Direction::Reverse)).unwrap();
    assert_eq!(back.moved, TurnDelta32(-((1 << 29) - 256_000)));
}

#[test]
fn between_edges_the_angle_goes_on_and_stops_at_the_next_edge() {
    let mut corrector = corrector();
    assert_eq!(corrector.angle_at(5), None);
    corrector.push(&step(1, 0, Direction::Forward));
    corrector.push(&step(2, 1000, Direction::Forward));
    let way = (1_u32 << 29) + 256_000;
    let half = corrector.angle_at(1500).unwrap();
    assert!(half.minus(Turn32((1 << 30) + way / 2)).0.abs() <= 2);
    let next = Turn32((3_u32 << 29) + 256_000);
    assert_eq!(corrector.angle_at(1_000_000).unwrap(), next);
    assert_eq!(corrector.angle_at(u64::MAX).unwrap(), next);
    // A clock read before the edge's own time gives the edge.
    assert_eq!(corrector.angle_at(3).unwrap(), Turn32(1 << 30));
}

#[test]
fn a_glitch_takes_the_last_edge_back() {
    let mut corrector = corrector();
    corrector.push(&step(0, 0, Direction::Forward));
    corrector.push(&step(1, 1000, Direction::Forward));
    corrector.push(&Outcome::Glitch(crate::step::Glitch {
        ticks: 1010,
        edge: 1,
        position: 0,
    }));
    assert_eq!(corrector.last().unwrap().ticks, 0);
}

/// Edges of an even shaft of eight edges a turn and 1000 ticks an edge, whose A rises (edges 0 and 4) are captured 100 ticks late.
fn delayed(direction: Direction) -> Corrector<'static> {
    let shape = EncoderShape::new(8, 4).unwrap();
    let table = ErrorTable::new(shape, [TurnDelta32(0); CLASSES_MAX], &[0; 8], 0).unwrap();
    let late = [25_600, 0, 0, 0, 0, 0].map(TickDelta8);
    let mut corrector = Corrector::new(table.with_delays(late), Anchor::Index);
    for k in 0..16_u32 {
        let edge = match direction {
            Direction::Forward => k % 8,
            Direction::Reverse => 7 - k % 8,
        };
        // In reverse A rises at edges 2 and 6.
        let rise = match direction {
            Direction::Forward => edge.is_multiple_of(4),
            Direction::Reverse => edge % 4 == 2,
        };
        let late = |rise: bool| if rise { 100 } else { 0 };
        let ticks = 1000 * Ticks::from(k + 1) + late(rise);
        // The edge before was the rise, either way.
        let before = edge % 4 == 1;
        let interval = (1000 + late(rise) - late(before)) as u32;
        let Outcome::Step(plain) = step(edge, ticks, direction) else {
            unreachable!()
        };
        let seen = corrector.push(&Outcome::Step(Step { interval, ..plain }));
        let seen = seen.unwrap();
        assert_eq!(
            seen.ticks - (seen.late.0 as Ticks >> 8),
            1000 * Ticks::from(k + 1)
        );
        assert_eq!(seen.interval_q8(), 256_000, "{direction:?} edge {edge}");
        assert_eq!(corrector.last(), Some(seen));
    }
    corrector
}

#[test]
fn delays_bend_neither_the_interval_nor_the_angle_between_edges() {
    let eighth = 1_i32 << 29;
    // The last edge, 7, was at 16,000 in fact. Edge 0 is due at 17,000, and seen at 17,100.
    let corrector = delayed(Direction::Forward);
    for (now, eighths_in_thousandths) in [
        (16_500, 500),
        (17_000, 1000),
        (17_100, 1100),
        (18_000, 1100),
    ] {
        let way = corrector.angle_at(now).unwrap().minus(Turn32(7 << 29)).0;
        let expected = i64::from(eighth) * eighths_in_thousandths / 1000;
        assert!(
            (i64::from(way) - expected).abs() < 8,
            "{now}: {way} {expected}"
        );
    }
    // In reverse the last edge is 0, where A falls, and the next one 7, where B falls: none of them late.
    let corrector = delayed(Direction::Reverse);
    for (now, thousandths) in [(16_500, 500), (17_000, 1000), (17_100, 1000)] {
        let way = corrector.angle_at(now).unwrap().minus(Turn32(0)).0;
        let expected = -i64::from(eighth) * thousandths / 1000;
        assert!(
            (i64::from(way) - expected).abs() < 8,
            "{now}: {way} {expected}"
        );
    }
}

proptest! {
    #[test]
    fn the_true_delays_give_the_times_of_the_shaft_to_half_a_fraction_of_a_tick(
        classes in 1u32..=6, forward in any::<bool>(), first in 1_000_000u64..1 << 48,
        gaps in prop::collection::vec(2000u32..1 << 30, 2..40), delays in prop::array::uniform6(-900.0..900.0_f64)
    ) {
        prop_assume!(60 % classes == 0);
        let direction = if forward { Direction::Forward } else { Direction::Reverse };
        let shape = EncoderShape::new(60, classes).unwrap();
        let table = ErrorTable::new(shape, [TurnDelta32(0); CLASSES_MAX], &[0; 60], 0).unwrap();
        let table = table.with_delays(delays.map(|delay| TickDelta8((delay * 256.0).round() as i32)));
        let mut corrector = Corrector::new(table, Anchor::Index);
        let (mut ticks, mut before) = (first, None::<f64>);
        for (k, gap) in (0u32..).zip(gaps) {
            let edge = if forward { k % 60 } else { 59 - k % 60 };
            let class = edge % classes;
            // By hand: in reverse the other edge of the same channel.
            let other = (class + classes / 2) % classes;
            let electrical = if forward || classes % 2 == 1 { class } else { other };
            ticks += Ticks::from(gap);
            let (flags, interval) = if k == 0 { (Flags::REFERENCED.with(Flags::FIRST), u32::MAX) } else { (Flags::REFERENCED, gap) };
            let step = Step { ticks, edge, position: edge, interval, resync: 0, advance: 1, flags, direction };
            let seen = corrector.push(&Outcome::Step(step)).unwrap();
            let late = delays[electrical as usize];
            prop_assert!((f64::from(seen.late.0) / 256.0 - late).abs() <= 0.5 / 256.0);
            if let Some(before) = before {
                let exact: f64 = f64::from(gap) - (late - before);
                prop_assert!((seen.interval_q8() as f64 / 256.0 - exact).abs() <= 1.0 / 256.0);
            }
            before = Some(late);
        }
    }

    #[test]
    fn a_plain_step_is_corrected_as_any_step(
        steps in prop::collection::vec((0u32..24, 0u16..16, any::<bool>(), 0u8..20, -1i32..2), 1..100), classes in 1u32..=6,
        offsets in prop::array::uniform6(-1000i32..1000), delays in prop::array::uniform6(-5000i32..5000)
    ) {
        prop_assume!(24 % classes == 0);
        let shape = EncoderShape::new(24, classes).unwrap();
        let entries: [i16; 24] = core::array::from_fn(|k| k as i16 * 77 - 900);
        let table = ErrorTable::new(shape, offsets.map(TurnDelta32), &entries, 4).unwrap();
        let table = table.with_delays(delays.map(TickDelta8));
        let (mut quick, mut careful) = (Corrector::new(table, Anchor::Index), Corrector::new(table, Anchor::Index));
        for (i, (edge, flags, forward, kind, resync)) in steps.into_iter().enumerate() {
            let direction = if forward { Direction::Forward } else { Direction::Reverse };
            let ticks = 100 * i as Ticks;
            let turned = quick.newest().direction != direction;
            let flags = if turned { Flags(flags).with(Flags::REVERSED) } else { Flags(flags) };
            // Only an index moves the count.
            let resync = if flags.contains(Flags::INDEX) { resync } else { 0 };
            let outcome = match kind {
                0 => Outcome::Glitch(crate::step::Glitch { ticks, edge, position: edge }),
                1 => Outcome::Index(crate::step::Reference { ticks, position: edge, resync, flags }),
                _ => Outcome::Step(Step {
                    ticks, edge, position: edge, interval: 100, resync, advance: 1, flags, direction,
                }),
            };
            careful.related = NO_RELATION;
            prop_assert_eq!(quick.push(&outcome), careful.push(&outcome));
            prop_assert_eq!(quick.last(), careful.last());
            prop_assert_eq!(quick.angle_at(ticks + 50), careful.angle_at(ticks + 50));
        }
    }
}
