//! The estimator as a whole, fed by the decoders.

use proptest::prelude::*;
use std::vec::Vec;

use super::*;
use crate::corrector::Corrector;
use crate::decoder::{DecoderConfig, QuadratureDecoder};
use crate::edge::{Levels, Sample};
use crate::hall::HallDecoder;
use crate::step::Outcome;
use crate::table::ErrorTable;
use crate::wheel::{WheelConfig, WheelDecoder};

const LINES: u32 = 16;
const EDGES: u32 = 4 * LINES;
const STEP: f64 = 65_536.0;

/// Buffers on the heap.
struct Heap(Vec<i32>, Vec<i16>, Vec<i32>);

impl Heap {
    fn new(edges: u32) -> Self {
        let edges = edges as usize;
        Self(
            std::vec![0; edges],
            std::vec![0; edges],
            std::vec![0; 3 * blocks_for(edges)],
        )
    }
}

impl EdgeBuffers for Heap {
    fn parts(&mut self) -> Parts<'_> {
        Parts {
            sum: &mut self.0,
            cells: &mut self.1,
            coarse: &mut self.2,
        }
    }

    fn cells(&self) -> &[i16] {
        &self.1
    }

    fn edges(&self) -> usize {
        self.0.len()
    }
}

fn estimator() -> Estimator<Heap> {
    let shape = EncoderShape::new(EDGES, 4).unwrap();
    Estimator::new(shape, Anchor::Index, Heap::new(EDGES)).unwrap()
}

/// An encoder whose edges come early by `error` (in steps), passed at constant speed in one direction.
struct Shaft {
    decoder: QuadratureDecoder,
    ticks: f64,
    edge: i64,
    speed: f64,
}

impl Shaft {
    fn new() -> Self {
        let decoder = QuadratureDecoder::new(DecoderConfig::new(LINES)).unwrap();
        Self {
            decoder,
            ticks: 1e6,
            edge: -3,
            speed: 1.0,
        }
    }

    fn error(edge: i64) -> f64 {
        let slot = edge.rem_euclid(i64::from(EDGES)) as f64;
        let class = [0.0, 0.12, -0.05, 0.2][edge.rem_euclid(4) as usize];
        class + 0.08 * (slot * 2.399).sin()
    }

    fn sample(&self, edge: i64, forward: bool) -> Sample {
        let after = if forward { edge } else { edge - 1 };
        let state = [1_u8, 3, 2, 0][after.rem_euclid(4) as usize];
        let index = if after.rem_euclid(i64::from(EDGES)) == 0 {
            Levels::Z
        } else {
            0
        };
        let position = edge as f64 - Self::error(edge);
        let ticks = self.ticks + position * STEP * self.speed;
        Sample {
            ticks: ticks as u64,
            levels: Levels(state | index),
        }
    }

    /// Passes `count` edges forward and hands what the decoder says to `visit`.
    fn forward(&mut self, count: i64, mut visit: impl FnMut(&Outcome)) {
        for _ in 0..count {
            self.edge += 1;
            let sample = self.sample(self.edge, true);
            visit(&self.decoder.push(sample));
        }
    }

    /// Takes up speed `speed` (time per step) without a jump in time.
    fn change_speed(&mut self, speed: f64) {
        self.ticks += self.edge as f64 * STEP * (self.speed - speed);
        self.speed = speed;
    }
}

fn turns(count: f64) -> i64 {
    (count * f64::from(EDGES)) as i64
}

#[test]
fn errors_are_found_from_whole_turns() {
    let (mut shaft, mut estimator) = (Shaft::new(), estimator());
    shaft.forward(turns(8.5), |outcome| {
        estimator.push(outcome);
    });
    assert_eq!(
        estimator.totals().turns,
        7,
        "of eight whole turns one sets the rate"
    );
    let solution = estimator.solve().unwrap();
    let truth: Vec<f64> = (0..i64::from(EDGES)).map(Shaft::error).collect();
    let mean = truth.iter().sum::<f64>() / f64::from(EDGES);
    let step = 4_294_967_296.0 / f64::from(EDGES);
    for (edge, &entry) in solution.entries().iter().enumerate() {
        let found = f64::from(solution.class_offset(edge % 4).0)
            + f64::from(i32::from(entry) << solution.shift());
        assert!(
            (found / step - (truth[edge] - mean)).abs() < 2e-3,
            "{edge}: {} {}",
            found / step,
            truth[edge]
        );
    }
}

/// A disc that is eccentric by so many steps, by `unlike` more at standstill, on a shaft whose speed falls with the angle to `left` of
/// the first in so many turns.
fn run_down([eccentricity, unlike]: [f64; 2], left: f64, count: f64) -> Solution<Heap> {
    let mut estimator = estimator();
    let mut decoder = QuadratureDecoder::new(DecoderConfig::new(LINES)).unwrap();
    let far = count * f64::from(EDGES) / (1.0 - left);
    for edge in -3..turns(count) {
        let levels = [1_u8, 3, 2, 0][edge.rem_euclid(4) as usize];
        let index = if edge.rem_euclid(i64::from(EDGES)) == 0 {
            Levels::Z
        } else {
            0
        };
        let at = core::f64::consts::TAU * edge as f64 / f64::from(EDGES);
        let size = eccentricity * (1.0 + unlike * edge as f64 / far);
        let position = edge as f64 - size * (at + 0.4).cos();
        let time = -far * (-position / far).ln_1p();
        estimator.push(&decoder.push(Sample {
            ticks: ((time + 10.0) * STEP) as u64,
            levels: Levels(levels | index),
        }));
    }
    estimator.solve().unwrap()
}

/// Friction that goes with the speed makes the acceleration change, as torque at the lowest orders would.
#[test]
fn a_shaft_that_runs_down_by_half_shows_no_torque() {
    let solution = run_down([0.0; 2], 0.5, 40.0);
    assert_eq!(solution.torque_orders(), []);
    // 3e-7 turn.
    assert!(
        solution.table_rms() < 1300,
        "{} {}",
        solution.table_rms(),
        solution.standard_error()
    );
}

#[test]
fn a_shaft_that_runs_down_by_a_quarter_tells_eccentricity_from_torque() {
    let solution = run_down([0.05, 0.0], 0.75, 33.0);
    assert_eq!(solution.locked_orders(), []);
    assert_eq!(solution.torque_orders(), []);
    let expected = 0.05 / 2.0_f64.sqrt() / f64::from(EDGES) * 4_294_967_296.0;
    let off = f64::from(solution.table_rms()) / expected - 1.0;
    assert!(off.abs() < 2e-3, "{off}");
}

/// What the speed does to a disc's mounting is no torque of a shaft whose speed hardly changes.
#[test]
fn an_eccentricity_that_grows_by_half_a_percent_is_no_torque() {
    let solution = run_down([0.05, 0.02], 0.75, 33.0);
    assert_eq!(solution.torque_orders(), []);
    let expected = 0.05 / 2.0_f64.sqrt() / f64::from(EDGES) * 4_294_967_296.0;
    let off = f64::from(solution.table_rms()) / expected - 1.0;
    assert!((0.0..5e-3).contains(&off), "{off}");
}

#[test]
fn a_lost_edge_costs_its_turn_and_no_other() {
    let (mut shaft, mut estimator) = (Shaft::new(), estimator());
    let mut rejected = 0;
    let mut feed = |estimator: &mut Estimator<_>, outcome: &Outcome| {
        if let Progress::TurnRejected(reason) = estimator.push(outcome) {
            assert_eq!(reason, Rejection::Broken);
            rejected += 1;
        }
    };
    shaft.forward(turns(4.5), |outcome| feed(&mut estimator, outcome));
    shaft.forward(1, |_| {});
    // The decoder saw that edge too; what the estimator misses is the same as a gap.
    shaft.forward(turns(5.0), |outcome| feed(&mut estimator, outcome));
    assert_eq!(rejected, 1);
    assert_eq!(estimator.totals().broken, 1);
    assert!(estimator.totals().turns >= 5);
    assert!(estimator.solve().is_ok());
}

#[test]
fn a_turn_that_changes_speed_is_left_out() {
    let (mut shaft, mut estimator) = (Shaft::new(), estimator());
    let mut reasons = Vec::new();
    for speed in [1.0, 1.4] {
        shaft.change_speed(speed);
        shaft.forward(turns(4.0), |outcome| {
            if let Progress::TurnRejected(reason) = estimator.push(outcome) {
                reasons.push(reason);
            }
        });
    }
    assert!(
        !reasons.is_empty()
            && reasons
                .iter()
                .all(|reason| *reason == Rejection::SpeedChange),
        "{reasons:?}"
    );
    assert!(estimator.totals().turns >= 4);
}

#[test]
fn one_turn_is_too_little() {
    let (mut shaft, mut estimator) = (Shaft::new(), estimator());
    shaft.forward(turns(2.5), |outcome| {
        estimator.push(outcome);
    });
    assert_eq!(estimator.totals().turns, 1);
    assert_eq!(estimator.solve().err(), Some(SolveError::TooFewTurns(1)));
}

#[test]
fn buffers_of_another_size_are_refused() {
    let shape = EncoderShape::new(EDGES + 4, 4).unwrap();
    let refused = Estimator::new(shape, Anchor::Index, Heap::new(EDGES)).err();
    assert_eq!(refused, Some(ShapeError::Buffers(EDGES as usize)));
}

/// Any levels at any times, sometimes long apart, sometimes backward.
fn any_samples() -> impl Strategy<Value = Vec<Sample>> {
    let gap = prop_oneof![6 => 0_u64..100_000, 1 => 0_u64..1 << 34, 1 => Just(u64::MAX / 7)];
    let levels = prop_oneof![3 => 0_u8..4, 1 => 0_u8..8];
    prop::collection::vec((gap, levels), 0..2000).prop_map(|steps| {
        let mut ticks = 0_u64;
        let sample = |(gap, levels)| {
            ticks = ticks.wrapping_add(gap);
            Sample {
                ticks,
                levels: Levels(levels),
            }
        };
        steps.into_iter().map(sample).collect()
    })
}

/// Learns from outcomes, solves, corrects the same outcomes, and asks for angles in between.
fn learn_and_correct(shape: EncoderShape, anchor: Anchor, outcomes: &[Outcome]) {
    let mut estimator = Estimator::new(shape, anchor, Heap::new(shape.edges())).unwrap();
    for outcome in outcomes {
        estimator.push(outcome);
    }
    let Ok(solution) = estimator.solve() else {
        return;
    };
    let entries = solution.entries();
    let table =
        ErrorTable::new(shape, *solution.class_offsets(), entries, solution.shift()).unwrap();
    let mut corrector = Corrector::new(table, anchor);
    for outcome in outcomes {
        if let Some(edge) = corrector.push(outcome) {
            for later in [0, 1000, 1 << 40] {
                assert!(corrector.angle_at(edge.ticks.wrapping_add(later)).is_some());
            }
        }
    }
}

proptest! {
    #[test]
    fn no_stream_of_samples_makes_the_core_panic(samples in any_samples(), lines in 1_u32..6) {
        let mut quadrature = QuadratureDecoder::new(DecoderConfig::new(lines)).unwrap();
        let outcomes: Vec<Outcome> = samples.iter().map(|&sample| quadrature.push(sample)).collect();
        learn_and_correct(EncoderShape::new(4 * lines, 4).unwrap(), Anchor::FirstEdge, &outcomes);

        let mut hall = HallDecoder::new(lines).unwrap();
        let outcomes: Vec<Outcome> = samples.iter().map(|&sample| hall.push(sample)).collect();
        learn_and_correct(EncoderShape::new(6 * lines, 6).unwrap(), Anchor::FirstEdge, &outcomes);

        let config = WheelConfig { both_edges: true, ..WheelConfig::new(lines + 2) };
        let mut wheel = WheelDecoder::new(config).unwrap();
        let outcomes: Vec<Outcome> = samples.iter().map(|&sample| wheel.push(sample)).collect();
        learn_and_correct(EncoderShape::new(2 * (lines + 2), 2).unwrap(), Anchor::FirstEdge, &outcomes);
    }
}
