//! Edges of one class that spread further than the others: a slow flank, a bad comparator. A twin has one jitter for all stamps.
//!
//! An edge less what all others let expect of it (see [`Whitener::precisions`](super::super::kalman::Whitener::precisions)) spreads by its
//! own stamp where the shaft itself is smooth enough, so each class shows what it has of its own.

use super::super::board::Board;
use super::super::classes::change_of;
use super::odds::normal_above;
use super::{NoiseFinding, NoiseParameter};
use crate::mechanism::Mechanism;
use crate::report::si;

/// Mean square of a class over that of the others from which on it is another's.
const WIDER: f64 = 1.5;
/// Standard errors that it stands out by.
const DEVIATIONS: f64 = 10.0;
/// Ticks that it spreads over at the least: rounding by itself is not alike for all classes.
const TICKS: f64 = 1.0;
/// Mean square of an edge beyond which it is an event.
const FAR: f64 = 36.0;

/// What the edges of a class come to.
#[derive(Clone, Copy, Debug, Default)]
struct Spread {
    count: f64,
    /// Sums of the squares over those expected, and of the squares of these.
    squares: f64,
    fourths: f64,
    /// Sum of the squares as times, s^2.
    times2: f64,
}

impl Spread {
    fn mean(&self) -> f64 {
        self.squares / self.count.max(1.0)
    }

    fn variance(&self) -> f64 {
        let count = self.count.max(1.0);
        (self.fourths / count - self.mean().powi(2)) / count
    }

    fn rms_s(&self) -> f64 {
        (self.times2 / self.count.max(1.0)).sqrt()
    }

    fn add(&mut self, other: &Self) {
        self.count += other.count;
        self.squares += other.squares;
        self.fourths += other.fourths;
        self.times2 += other.times2;
    }
}

/// Classes whose edges spread further than those of the others, in what is left of all recordings, white.
#[must_use]
pub fn find(board: &Board, left: &[Vec<f64>]) -> Option<NoiseFinding> {
    let classes = board.benches.first()?.seen.classes;
    let mut each = vec![Spread::default(); usize::try_from(classes).ok()?];
    for (bench, left) in board.benches.iter().zip(left) {
        let mut pulled = left.clone();
        bench.transposed(&mut pulled);
        let precisions = bench.whitener().precisions();
        for (at, (pull, precision)) in pulled.iter().zip(precisions).enumerate() {
            let square = pull * pull / precision;
            let speed = bench.seen.true_speed(at);
            if precision > 0.0 && square < FAR * FAR && speed != 0.0 {
                let square = square.min(FAR);
                let time_s = square.sqrt() / precision.sqrt() / speed;
                each[bench.seen.class(at)].add(&Spread {
                    count: 1.0,
                    squares: square,
                    fourths: square * square,
                    times2: time_s * time_s,
                });
            }
        }
    }
    let mut order: Vec<usize> = (0..each.len()).collect();
    order.sort_by(|a, b| each[*b].mean().total_cmp(&each[*a].mean()));
    // Where they fall apart most.
    let (wide, rest) = (1..order.len())
        .map(|at| order.split_at(at))
        .max_by(|a, b| {
            let gap = |split: &(&[usize], &[usize])| {
                let (last, first) = (split.0[split.0.len() - 1], split.1[0]);
                each[last].mean() / each[first].mean().max(f64::MIN_POSITIVE)
            };
            gap(a).total_cmp(&gap(b))
        })?;
    let sum = |of: &[usize]| {
        let mut sum = Spread::default();
        of.iter().for_each(|class| sum.add(&each[*class]));
        sum
    };
    let (wider, others) = (sum(wide), sum(rest));
    let least = wide
        .iter()
        .map(|class| each[*class].mean())
        .fold(f64::INFINITY, f64::min);
    let most = rest
        .iter()
        .map(|class| each[*class].mean())
        .fold(0.0, f64::max);
    let deviations = (least - most) / (wider.variance() + others.variance()).sqrt();
    let tick_s = board
        .benches
        .iter()
        .map(|bench| bench.least_stamp_s * 12_f64.sqrt());
    let tick_s = tick_s.fold(0.0, f64::max);
    if least < WIDER * most || deviations < DEVIATIONS || wider.rms_s() < TICKS * tick_s {
        return None;
    }
    let mut edge_classes = wide.to_vec();
    edge_classes.sort_unstable();
    let names: Vec<String> = edge_classes
        .iter()
        .map(|class| named(*class, classes))
        .collect();
    let times = wider.rms_s() / others.rms_s();
    Some(NoiseFinding {
        mechanism: Mechanism::Unknown,
        parameters: vec![
            NoiseParameter {
                name: "share",
                value: wider.count / (wider.count + others.count),
                standard_error: 0.0,
            },
            NoiseParameter {
                name: "times_as_wide",
                value: times,
                standard_error: 0.5
                    * times
                    * (wider.variance().sqrt() / wider.mean())
                        .hypot(others.variance().sqrt() / others.mean()),
            },
        ],
        delta_bic: deviations * deviations - (board.edges() as f64).ln(),
        p_value: normal_above(deviations),
        text: format!(
            "stamps of {} spread by {} RMS, those of the other edges by {}",
            names.join(" and "),
            si(wider.rms_s(), "s"),
            si(others.rms_s(), "s")
        ),
        frequencies_hz: Vec::new(),
        times_s: Vec::new(),
        edge_classes,
        runner_up: None,
        busy: None,
    })
}

fn named(class: usize, classes: i64) -> String {
    let change = change_of(class, classes);
    let flank = if change.rises { "rises" } else { "falls" };
    match classes {
        4 | 6 => format!("{}'s {flank}", ["A", "B", "C"][change.channel.min(2)]),
        _ => flank.to_owned(),
    }
}
