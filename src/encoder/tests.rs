//! The encoder against its parts, bit for bit, and against a shaft whose speed and angle are known.

use super::*;
use crate::decoder::tests::disturbed;
use crate::edge::Levels;
use crate::interval::ErrorChange;
use crate::shape::{CLASSES_MAX, ShapeError};
use crate::step::Flags;
use crate::timebase::Timebase16;
use crate::units::TickDelta8;
use proptest::prelude::*;
use std::vec::Vec;

const TIMEOUT: Ticks = 1 << 20;
const STATES: [u8; 4] = [1, 3, 2, 0];

const fn is_send<T: Send>() {}
const _: () = is_send::<Encoder<'static>>();

/// The parts, wired by hand as the pages say, with e(k) from the table itself.
struct Parts<'a> {
    decoder: QuadratureDecoder,
    corrector: Corrector<'a>,
    interval: Interval,
    table: Option<ErrorTable<'a>>,
    /// Number and reference of the step before, and of the one before that.
    before: [Option<(u32, bool)>; 2],
}

impl<'a> Parts<'a> {
    fn new(config: EncoderConfig, table: Option<ErrorTable<'a>>) -> Self {
        let decoder = QuadratureDecoder::new(config.decoder).unwrap();
        let shape = EncoderShape::new(decoder.slots(), 4).unwrap();
        let corrector = match table {
            Some(table) => Corrector::new(table, config.anchor),
            None => Corrector::uncorrected(Grid::new(shape)),
        };
        Self {
            decoder,
            corrector,
            interval: Interval::new(IntervalConfig::new(decoder.slots(), config.timeout)),
            table,
            before: [None; 2],
        }
    }

    fn push(&mut self, sample: Sample) -> Option<(CorrectedEdge, Speed)> {
        let outcome = self.decoder.push(sample);
        let corrected = self.corrector.push(&outcome);
        match outcome {
            Outcome::Step(step) => {
                let edge = corrected.unwrap();
                let this = (step.edge, step.flags.contains(Flags::REFERENCED));
                let change = match (self.before[0], self.table) {
                    (Some(before), Some(table)) if before.1 == this.1 && step.resync == 0 => {
                        ErrorChange::from_to(
                            table.error(before.0, this.1),
                            table.error(this.0, this.1),
                        )
                    }
                    _ => ErrorChange::NONE,
                };
                self.before = [Some(this), self.before[0]];
                self.interval.push_delayed(&step, change, edge.stretch);
                return Some((edge, self.interval.x4().unwrap_or(Speed::ZERO)));
            }
            Outcome::Glitch(_) => {
                self.interval.withdraw();
                self.before[0] = self.before[1];
            }
            Outcome::Index(index) if index.resync != 0 => self.before[0] = None,
            _ => {}
        }
        None
    }
}

fn encoder_is_its_parts(
    slots: u32,
    samples: &[Sample],
    table: Option<ErrorTable<'_>>,
) -> Result<(), TestCaseError> {
    let config = EncoderConfig::new(slots / 4, TIMEOUT);
    let mut parts = Parts::new(config, table);
    let mut encoder: Encoder<'_, i16, 16> = Encoder::new(config, table).unwrap();
    let mut plain = 0;
    for (i, sample) in samples.iter().enumerate() {
        let seen = encoder.edge_at(*sample);
        let expected = parts.push(*sample);
        prop_assert_eq!(
            seen.map(|seen| (seen.edge, seen.speed())),
            expected,
            "row {}",
            i
        );
        prop_assert_eq!(
            encoder.last().map(|last| last.edge),
            parts.corrector.last(),
            "row {}",
            i
        );
        plain += usize::from(encoder.last_plain().is_some());
        for later in [0, 100, 700, 3000, 1 << 19, 1 << 24, 1 << 33] {
            let now = sample.ticks + later;
            let (angle, expected) = (encoder.now(now), parts.corrector.angle_at(now));
            prop_assert_eq!(angle.is_some(), expected.is_some(), "row {}", i);
            if let Some((angle, expected)) = angle.zip(expected) {
                let last = encoder.last().unwrap().edge;
                let steps = (now - last.ticks) / u64::from(last.interval.max(1));
                let off = u64::from(angle.minus(expected).0.unsigned_abs());
                prop_assert!(off <= 2 * steps + 4, "row {} + {}: {}", i, later, off);
            }
            prop_assert_eq!(
                encoder.speed_at(now),
                parts.interval.speed_at(now),
                "row {} + {}",
                i,
                later
            );
        }
        prop_assert_eq!(encoder.now(0), parts.corrector.angle_at(0));
    }
    prop_assert_eq!(encoder.faults(), parts.decoder.faults());
    prop_assert!(plain > samples.len() / 8, "{} of {}", plain, samples.len());
    Ok(())
}

proptest! {
    #[test]
    fn encoder_with_a_table_is_its_parts(
        (slots, samples) in disturbed(), seed in any::<i16>(), shift in 0u32..10,
        offsets in prop::array::uniform6(-1000i32..1000), delays in prop::array::uniform6(-5000i32..5000), delayed: bool
    ) {
        let shape = EncoderShape::new(slots, 4).unwrap();
        let entries: Vec<i16> = (0..slots).map(|k| (k as i16).wrapping_mul(seed)).collect();
        let table = ErrorTable::new(shape, offsets.map(TurnDelta32), &entries, shift).unwrap();
        let table = if delayed { table.with_delays(delays.map(TickDelta8)) } else { table };
        encoder_is_its_parts(slots, &samples, Some(table))?;
    }

    #[test]
    fn encoder_without_a_table_is_its_parts((slots, samples) in disturbed()) {
        encoder_is_its_parts(slots, &samples, None)?;
    }

    #[test]
    fn captures_of_a_timer_that_overflows_are_those_of_one_that_does_not((slots, samples) in disturbed()) {
        let config = EncoderConfig::new(slots / 4, TIMEOUT);
        let mut short: Encoder = Encoder::new(config, None).unwrap();
        let mut long: Encoder = Encoder::new(config, None).unwrap();
        let mut base = Timebase16::new();
        for (i, sample) in samples.iter().enumerate() {
            let wraps = sample.ticks >> 16;
            // Served after the capture every other time.
            let late = i % 2 == 1 && sample.ticks & 0xFFFF < 0x8000 && base.now(0, false) >> 16 < wraps;
            while base.now(0, false) >> 16 < wraps - u64::from(late) {
                base.overflow();
                short.overflow();
            }
            let capture = Capture { raw: (sample.ticks & 0xFFFF) as u32, overflow_pending: late, levels: sample.levels };
            prop_assert_eq!(short.edge(capture), long.edge_at(*sample));
            prop_assert_eq!(short.time(capture.raw, late), sample.ticks);
        }
    }

    #[test]
    fn between_edges_the_angle_only_goes_on_and_stays_between_them(
        (slots, samples) in disturbed(), seed in any::<i16>()
    ) {
        let shape = EncoderShape::new(slots, 4).unwrap();
        let entries: Vec<i16> = (0..slots).map(|k| (k as i16).wrapping_mul(seed)).collect();
        let table = ErrorTable::new(shape, [TurnDelta32(0); CLASSES_MAX], &entries, 6).unwrap();
        let mut encoder: Encoder<'_, i16> = Encoder::new(EncoderConfig::new(slots / 4, TIMEOUT), Some(table)).unwrap();
        for pair in samples.windows(2) {
            let Some(seen) = encoder.edge_at(pair[0]) else { continue };
            let (from, to) = (pair[0].ticks, pair[1].ticks.max(pair[0].ticks));
            let sign = i64::from(encoder.latest.sign);
            let way = |angle: Turn32| i64::from(angle.minus(seen.edge.angle).0) * sign;
            let most = way(encoder.latest.ahead);
            let mut before = 0;
            for part in 0..=16 {
                let now = encoder.now(from + (to - from) * part / 8).unwrap();
                prop_assert!((before..=most).contains(&way(now)));
                before = way(now);
            }
        }
    }

    #[test]
    fn any_samples_at_any_time_are_taken(
        rows in prop::collection::vec((any::<u64>(), any::<u8>(), any::<u64>(), 0u8..40), 1..400), lines in 1u32..9
    ) {
        let config = EncoderConfig::new(lines, TIMEOUT);
        let mut encoder: Encoder<'_, i16> = Encoder::new(config, None).unwrap();
        let mut ticks = 0_u64;
        for (gap, levels, now, kind) in rows {
            // Most rows are soon after the one before.
            ticks = ticks.wrapping_add(if kind < 35 { gap & 0xFFF } else { gap });
            let _ = encoder.edge_at(Sample { ticks, levels: Levels(levels) }).map(|seen| seen.speed());
            let _ = (encoder.now(now), encoder.now(ticks.wrapping_add(now & 0xFFF)), encoder.speed_at(now));
            match kind {
                0 => encoder.release(),
                1 => encoder.set_table(None).unwrap(),
                2 => { encoder.locate(gap as u32); }
                _ => {}
            }
        }
    }
}

/// 1000 edges a turn with errors up to 15 % of a step, at a rate of `interval` ticks an edge; the table knows the errors.
fn a_known_rotation(interval: f64, forward: bool) {
    let shape = EncoderShape::new(1000, 4).unwrap();
    let entries: Vec<i16> = (0..1000_i32)
        .map(|k| ((k * 7919 % 1280) - 640) as i16)
        .collect();
    let table = ErrorTable::new(shape, [TurnDelta32(0); CLASSES_MAX], &entries, 10).unwrap();
    let mut encoder: Encoder<'_, i16> =
        Encoder::new(EncoderConfig::new(250, TIMEOUT), Some(table)).unwrap();
    let exact = (1_u64 << 60) as f64 / 1000.0 / interval * if forward { 1.0 } else { -1.0 };
    let step = 2_f64.powi(32) / 1000.0;
    for k in 1..5000_i64 {
        let place = if forward { k } else { 5000 - k };
        let edge = place.rem_euclid(1000);
        let error = f64::from(i32::from(entries[edge as usize]) << 10) / step;
        // A mark whose error is e stands e before its place on the grid.
        let late = if forward { -error } else { error };
        let ticks = ((k as f64 + late) * interval).round() as Ticks;
        let position = if forward { place } else { place - 1 }.rem_euclid(1000);
        let z = if position == 0 { Levels::Z } else { 0 };
        let levels = Levels(STATES[(position % 4) as usize] | z);
        let seen = encoder.edge_at(Sample { ticks, levels });
        if k > 2200 {
            let seen = seen.unwrap();
            // Both time stamps are whole ticks; the shortest interval is 0.7 of the mean one.
            let off = seen.speed().0 as f64 / exact - 1.0;
            assert!(
                off.abs() < 1.0 / (0.7 * interval) + 1e-8,
                "edge {k}: {off:e}"
            );
            // And the angle is right to half a tick of the motion.
            let shaft = ticks as f64 / interval * if forward { 1.0 } else { -1.0 };
            let shaft = (shaft + if forward { 0.0 } else { 5000.0 }) * step;
            let off = seen
                .edge
                .angle
                .minus(Turn32(shaft.rem_euclid(2_f64.powi(32)) as u32))
                .0;
            assert!(
                f64::from(off).abs() < 0.5 * step / interval + 3.0,
                "edge {k}: {off}"
            );
        }
    }
}

#[test]
fn speed_and_angle_of_a_known_rotation_are_right_to_the_tick() {
    for interval in [200.0, 840.3, 50_000.7] {
        a_known_rotation(interval, true);
        a_known_rotation(interval, false);
    }
}

#[test]
fn a_table_of_another_encoder_and_too_many_lines_are_refused() {
    let too_many = Encoder::<'_, i16>::new(EncoderConfig::new(16_385, 1), None);
    assert_eq!(
        too_many.err(),
        Some(EncoderError::Shape(ShapeError::Edges(65_540)))
    );
    let shape = EncoderShape::new(1000, 2).unwrap();
    let table = ErrorTable::new(shape, [TurnDelta32(0); CLASSES_MAX], &[0_i16; 1000], 0).unwrap();
    let other = Encoder::<'_, i16>::new(EncoderConfig::new(250, 1), Some(table));
    assert_eq!(other.err(), Some(EncoderError::Table(shape)));
}
