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

proptest! {
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
