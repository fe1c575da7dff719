//! The decoder against a simulated shaft whose true position is known.

use super::*;
use crate::step::Glitch;
use proptest::prelude::*;
use std::vec::Vec;

const STATES: [u8; 4] = [1, 3, 2, 0];

fn decoder(lines: u32) -> QuadratureDecoder {
    QuadratureDecoder::new(DecoderConfig::new(lines)).unwrap()
}

fn sample(ticks: u64, levels: u8) -> Sample {
    Sample {
        ticks,
        levels: Levels(levels),
    }
}

/// A row of the simulated recording and the true position after it.
#[derive(Clone, Copy, Debug)]
struct Row {
    sample: Sample,
    position: u32,
    /// True for a change of A or B.
    edge: bool,
    direction: i64,
}

/// A shaft in steps and ticks that moves with piecewise constant acceleration past edges displaced by `error`.
struct Rig {
    slots: i64,
    error: Vec<f64>,
    time: f64,
    place: f64,
    speed: f64,
    /// Marks passed, in half steps: even ones are edges, odd ones may be Z.
    mark: i64,
    rows: Vec<Row>,
}

impl Rig {
    fn new(error: Vec<f64>, speed: f64) -> Self {
        let mut rig = Self {
            slots: error.len() as i64,
            error,
            time: 1e6,
            place: 2.5,
            speed,
            mark: 5,
            rows: Vec::new(),
        };
        rig.emit(1e6, false, 1);
        rig
    }

    fn place_of(&self, mark: i64) -> f64 {
        let edge = mark.div_euclid(2).rem_euclid(self.slots) as usize;
        let displaced = if mark % 2 == 0 { self.error[edge] } else { 0.0 };
        mark as f64 / 2.0 + displaced
    }

    /// Moves on by `steps` (not across a reversal) while the speed goes to `target` at constant acceleration.
    fn travel(&mut self, steps: f64, target: f64) {
        let acceleration = (target * target - self.speed * self.speed) / (2.0 * steps);
        let direction: i64 = if steps > 0.0 { 1 } else { -1 };
        let (from, end) = (self.place, self.place + steps);
        let time_at = |place: f64| {
            let way = place - from;
            let speed = (self.speed * self.speed + 2.0 * acceleration * way).max(0.0);
            let speed = speed.sqrt() * direction as f64;
            self.time + 2.0 * way / (self.speed + speed)
        };
        let mut events = Vec::new();
        // Forward the mark crossed is the next one; backward it is the present one.
        let mut mark = self.mark;
        loop {
            let crossed = if direction > 0 { mark + 1 } else { mark };
            let place = self.place_of(crossed);
            if (place - end) * direction as f64 > 0.0 {
                break;
            }
            mark += direction;
            events.push((
                time_at(place.clamp(from.min(end), from.max(end))),
                crossed,
                mark,
            ));
        }
        let end_time = time_at(end);
        for (time, crossed, mark) in events {
            self.mark = mark;
            let turn = crossed.rem_euclid(2 * self.slots);
            if crossed % 2 == 0 {
                self.emit(time, true, direction);
            } else if turn == 1 || turn == 2 * self.slots - 1 {
                self.emit(time, false, direction);
            }
        }
        (self.time, self.place, self.speed) = (end_time, end, target);
    }

    fn emit(&mut self, time: f64, edge: bool, direction: i64) {
        // Z is high from half a step before edge 0 to half a step after: marks -1 and 0 hold it.
        let turn = 2 * self.slots;
        let within = self.mark.rem_euclid(turn);
        let z = within == 0 || within == turn - 1;
        let position = self.mark.div_euclid(2).rem_euclid(self.slots) as u32;
        let levels = STATES[(position % 4) as usize] | if z { Levels::Z } else { 0 };
        self.rows.push(Row {
            sample: sample(time as u64, levels),
            position,
            edge,
            direction,
        });
    }

    /// Slows down to a stop over `steps`, turns and speeds up again over as many.
    fn turn_round(&mut self, steps: f64) {
        let speed = self.speed;
        self.travel(steps * speed.signum(), 1e-12 * speed.signum());
        self.speed = -1e-12 * speed.signum();
        self.travel(-steps * speed.signum(), -speed);
    }
}

#[derive(Clone, Debug)]
enum Leg {
    Cruise { steps: f64, change: f64 },
    Turn { steps: f64 },
}

fn legs() -> impl Strategy<Value = Vec<Leg>> {
    let leg = prop_oneof![
        4 => (100.0..600.0f64, -0.1..0.1f64).prop_map(|(steps, change)| Leg::Cruise { steps, change }),
        1 => (30.0..150.0f64).prop_map(|steps| Leg::Turn { steps }),
    ];
    prop::collection::vec(leg, 1..12)
}

fn errors(size: f64) -> impl Strategy<Value = Vec<f64>> {
    let classes = prop::array::uniform4(-size / 2.0..size / 2.0);
    (8usize..24, classes).prop_flat_map(move |(lines, classes)| {
        prop::collection::vec(-size / 2.0..size / 2.0, 4 * lines).prop_map(move |eps| {
            eps.iter()
                .enumerate()
                .map(|(k, e)| e + classes[k % 4])
                .collect()
        })
    })
}

/// Runs the legs, then as many turns forward as settle every doubt.
fn recording(error: Vec<f64>, legs: &[Leg], interval: f64) -> Vec<Row> {
    let turn = error.len() as f64;
    let mut rig = Rig::new(error, 1.0 / interval);
    rig.travel(2.0 * turn, 1.0 / interval);
    for leg in legs {
        match *leg {
            // At most a tenth of the speed over a hundred edges.
            Leg::Cruise { steps, change } => {
                rig.travel(steps * rig.speed.signum(), rig.speed * (1.0 + change))
            }
            Leg::Turn { steps } => rig.turn_round(steps),
        }
    }
    if rig.speed < 0.0 {
        rig.turn_round(60.0);
    }
    rig.travel(5.0 * turn, rig.speed);
    rig.rows
}

#[derive(Clone, Copy, Debug)]
enum Event {
    Drop(usize),
    Insert([(f64, u8); 2], usize),
}

fn event() -> impl Strategy<Value = Event> {
    prop_oneof![
        (1usize..=4).prop_map(Event::Drop),
        (prop::array::uniform2((0.01..0.99f64, 0u8..8)), 1usize..=2)
            .prop_map(|(rows, n)| Event::Insert(rows, n)),
    ]
}

/// Rows with events, each with the truth; no truth for spurious rows. An event is kept away from the start, the end and
/// reversals, where lost edges can't be seen. Only the first may be a false index: while an earlier one has left the count in doubt,
/// no decoder could tell that from the true one.
fn disturb(
    rows: &[Row],
    events: &[(usize, Event)],
    clean_tail: usize,
) -> (Vec<(Sample, Option<Row>)>, Vec<usize>) {
    let mut out = Vec::new();
    let mut places = Vec::new();
    let (mut next, mut quiet, mut i) = (0, 0, 0);
    while i < rows.len() {
        let window = &rows[i.saturating_sub(30)..(i + 30).min(rows.len())];
        let even = window.iter().all(|row| row.direction == rows[i].direction);
        let planned = events
            .get(next)
            .filter(|(gap, _)| quiet > *gap && even && i > 200 && i + clean_tail < rows.len());
        match planned {
            Some((_, Event::Drop(n))) => {
                places.push(out.len());
                i += n;
                (next, quiet) = (next + 1, 0);
                continue;
            }
            Some((_, Event::Insert(spurious, n))) => {
                places.push(out.len());
                let (from, to) = (rows[i - 1].sample.ticks, rows[i].sample.ticks);
                let mut spurious: Vec<_> = spurious[..*n].to_vec();
                spurious.sort_by(|a, b| a.0.total_cmp(&b.0));
                for (part, levels) in spurious {
                    let levels = if places.len() > 1 { levels & 3 } else { levels };
                    out.push((
                        sample(from + (part * (to - from) as f64) as u64, levels),
                        None,
                    ));
                }
                (next, quiet) = (next + 1, 0);
            }
            None => {}
        }
        out.push((rows[i].sample, Some(rows[i])));
        quiet += 1;
        i += 1;
    }
    (out, places)
}

/// Edges a turn, and samples of a shaft that turns round, with edges lost and spurious ones: for tests of what stands on the decoder.
pub(crate) fn disturbed() -> impl Strategy<Value = (u32, Vec<Sample>)> {
    let events = prop::collection::vec((60usize..400, event()), 0..6);
    (errors(0.3), legs(), 500.0..5000.0f64, events).prop_map(|(error, legs, interval, events)| {
        let slots = error.len();
        let (samples, _) = disturb(&recording(error, &legs, interval), &events, 4 * slots);
        let samples = samples.into_iter().map(|(sample, _)| sample).collect();
        (slots as u32, samples)
    })
}

proptest! {
    #[test]
    fn position_is_exact_and_certain_on_a_clean_recording(
        error in errors(0.1), legs in legs(), interval in 500.0..5000.0f64
    ) {
        let rows = recording(error.clone(), &legs, interval);
        let mut decoder = decoder(error.len() as u32 / 4);
        for (i, row) in rows.iter().enumerate() {
            decoder.push(row.sample);
            if decoder.is_referenced() {
                prop_assert_eq!(decoder.position(), row.position, "row {}", i);
                prop_assert!(!decoder.is_uncertain(), "row {}: {:?}", i, decoder.faults());
            }
        }
        prop_assert!(decoder.is_referenced());
        // A pulse at a turning point may fall under the gate; nothing else may be counted.
        prop_assert_eq!(decoder.faults().total(), decoder.faults().glitch);
    }

    #[test]
    fn position_is_exact_with_edge_errors_of_30_percent(
        error in errors(0.3), legs in legs(), interval in 500.0..5000.0f64
    ) {
        let rows = recording(error.clone(), &legs, interval);
        let mut decoder = decoder(error.len() as u32 / 4);
        for row in &rows {
            decoder.push(row.sample);
            if decoder.is_referenced() {
                prop_assert_eq!(decoder.position(), row.position);
            }
        }
        prop_assert_eq!(decoder.faults().lost + decoder.faults().extra, 0);
    }

    #[test]
    fn position_is_never_off_without_being_uncertain(
        error in errors(0.3), legs in legs(), interval in 500.0..5000.0f64,
        events in prop::collection::vec((60usize..400, event()), 1..6)
    ) {
        let slots = error.len();
        let rows = recording(error, &legs, interval);
        let (samples, places) = disturb(&rows, &events, 4 * slots);
        let mut decoder = decoder(slots as u32 / 4);
        let mut unflagged = 0;
        for (i, (sample, truth)) in samples.iter().enumerate() {
            decoder.push(*sample);
            prop_assert_eq!(class_of(sample.levels), decoder.position() & 3);
            let Some(row) = truth else { continue };
            if !decoder.is_referenced() {
                continue;
            }
            if decoder.position() == row.position || decoder.is_uncertain() {
                unflagged = 0;
            } else {
                unflagged += u32::from(row.edge);
                prop_assert!(unflagged <= 1, "row {} after events at {:?}: {:?} {:?}", i, places, decoder, &samples[i-4..=i]);
            }
        }
        let last = rows[rows.len() - 1];
        prop_assert_eq!(decoder.position(), last.position);
        prop_assert!(!decoder.is_uncertain());
    }

    #[test]
    fn a_plain_step_is_what_a_closer_look_makes_of_it(
        error in errors(0.3), legs in legs(), interval in 500.0..5000.0f64,
        events in prop::collection::vec((60usize..400, event()), 0..6)
    ) {
        let slots = error.len();
        let rows = recording(error, &legs, interval);
        let (samples, _) = disturb(&rows, &events, 4 * slots);
        let mut quick = decoder(slots as u32 / 4);
        let mut careful = quick;
        let mut plain = 0;
        for (i, (sample, _)) in samples.iter().enumerate() {
            careful.next = Plain::NONE;
            plain += usize::from(quick.next != Plain::NONE);
            prop_assert_eq!(quick.push(*sample), careful.push(*sample), "row {}", i);
            prop_assert_eq!(quick.motion, careful.motion, "row {}", i);
        }
        careful.next = quick.next;
        prop_assert_eq!(quick, careful);
        prop_assert!(plain > samples.len() / 4, "{} of {}", plain, samples.len());
    }

    #[test]
    fn arbitrary_samples_keep_the_class_and_are_counted(
        rows in prop::collection::vec((0u64..1 << 34, any::<u8>()), 1..400), lines in 1u32..9, state in 0u8..4
    ) {
        let config = DecoderConfig { index_state: Levels(state), ..DecoderConfig::new(lines) };
        let mut decoder = QuadratureDecoder::new(config).unwrap();
        let mut before: Option<u8> = None;
        let (mut illegal, mut repeated) = (0, 0);
        for (ticks, levels) in rows {
            decoder.push(sample(ticks, levels));
            prop_assert!(decoder.position() < 4 * lines);
            prop_assert_eq!(class_of(Levels(levels)), decoder.position() & 3);
            if let Some(before) = before {
                illegal += u32::from((levels ^ before) & 3 == 3);
                repeated += u32::from((levels ^ before) & 7 == 0);
            }
            before = Some(levels);
        }
        prop_assert_eq!(decoder.faults().illegal, illegal);
        prop_assert_eq!(decoder.faults().repeated, repeated);
    }
}

/// Feeds `count` forward edges from `from` on, 1000 ticks apart, and returns the last outcome.
fn run(decoder: &mut QuadratureDecoder, from: u64, count: u64) -> Outcome {
    let mut last = Outcome::Idle;
    for k in from..from + count {
        last = decoder.push(sample(k * 1000, STATES[(k % 4) as usize]));
    }
    last
}

#[test]
fn a_step_names_the_edge_it_crossed_in_both_directions() {
    let mut decoder = decoder(2);
    run(&mut decoder, 0, 10);
    let forward = decoder.push(sample(10_000, STATES[2])).step().unwrap();
    assert_eq!(
        (forward.edge, forward.position, forward.interval),
        (2, 2, 1000)
    );
    let back = decoder.push(sample(40_000, STATES[1])).step().unwrap();
    assert_eq!(
        (back.edge, back.position, back.direction),
        (2, 1, Direction::Reverse)
    );
    assert!(back.flags.contains(Flags::REVERSED) && !back.flags.contains(Flags::FIRST));
}

#[test]
fn a_short_pulse_is_withdrawn_and_leaves_no_trace() {
    let mut decoder = decoder(8);
    run(&mut decoder, 0, 20);
    let before = decoder;
    decoder.push(sample(19_500, STATES[0]));
    let outcome = decoder.push(sample(19_600, STATES[3]));
    assert_eq!(
        outcome,
        Outcome::Glitch(Glitch {
            ticks: 19_600,
            edge: 20,
            position: 19
        })
    );
    decoder.push(sample(19_700, STATES[2]));
    let outcome = decoder.push(sample(19_800, STATES[3]));
    assert_eq!(
        outcome,
        Outcome::Glitch(Glitch {
            ticks: 19_800,
            edge: 19,
            position: 19
        })
    );
    assert_eq!(decoder.position(), before.position());
    assert_eq!(decoder.direction(), before.direction());
    assert!(!decoder.is_uncertain());
    assert_eq!(
        *decoder.faults(),
        Faults {
            glitch: 2,
            ..Faults::new()
        }
    );
    let next = run(&mut decoder, 20, 1).step().unwrap();
    assert_eq!(
        (next.interval, next.edge, next.flags),
        (1000, 20, Flags::NONE)
    );
}

#[test]
fn the_index_references_then_counts_lost_edges_then_agrees() {
    let mut decoder = decoder(8);
    run(&mut decoder, 0, 12);
    let index = decoder
        .push(sample(12_000, STATES[0] | Levels::Z))
        .step()
        .unwrap();
    assert_eq!((index.position, index.resync), (0, 0));
    assert!(index.flags.contains(Flags::INDEX.with(Flags::REFERENCED)));
    run(&mut decoder, 13, 27);
    let index = decoder
        .push(sample(40_000, STATES[0] | Levels::Z))
        .step()
        .unwrap();
    assert_eq!((index.position, index.edge, index.resync), (0, 0, 4));
    assert!(index.flags.contains(Flags::TURN_SUSPECT) && decoder.is_uncertain());
    assert_eq!((decoder.faults().lost, decoder.faults().extra), (4, 0));
    run(&mut decoder, 41, 31);
    let index = decoder
        .push(sample(72_000, STATES[0] | Levels::Z))
        .step()
        .unwrap();
    assert!(index.flags.contains(Flags::TURN_SUSPECT) && index.resync == 0);
    assert!(!decoder.is_uncertain());
}

#[test]
fn an_index_within_the_sector_is_found_at_the_change_of_z() {
    let mut decoder = decoder(8);
    run(&mut decoder, 0, 13);
    let outcome = decoder.push(sample(12_500, STATES[0] | Levels::Z));
    let Outcome::Index(index) = outcome else {
        panic!("{outcome:?}")
    };
    assert_eq!((index.position, index.resync), (0, 0));
    assert_eq!(decoder.push(sample(12_600, STATES[0])), Outcome::Idle);
    assert_eq!(decoder.faults().total(), 0);
}

#[test]
fn impossible_settings_are_refused() {
    let refused = |config| QuadratureDecoder::new(config).unwrap_err();
    assert_eq!(refused(DecoderConfig::new(0)), SensorError::Slots);
    assert_eq!(refused(DecoderConfig::new(u32::MAX)), SensorError::Slots);
    let config = DecoderConfig {
        glitch_gate: 1,
        ..DecoderConfig::new(8)
    };
    assert_eq!(refused(config), SensorError::Gate);
}
