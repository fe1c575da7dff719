//! Whole numbers against double precision, and what is better, worse and neither.

use super::*;
use std::vec::Vec;

/// Numbers between -1 and 1 that look random.
struct Noise(u64);

impl Noise {
    fn next(&mut self) -> f64 {
        self.0 ^= self.0 << 13;
        self.0 ^= self.0 >> 7;
        self.0 ^= self.0 << 17;
        (self.0 >> 11) as f64 / (1_u64 << 52) as f64 - 1.0
    }
}

const TURN: f64 = 4_294_967_296.0;

/// An encoder of `edges` with errors of a step's hundredth, turned so that speed drifts and swings.
struct Run {
    edges: usize,
    turns: usize,
    drift: f64,
    swing: f64,
    seed: u64,
    direction: Direction,
}

struct Turned {
    steps: Vec<Step>,
    /// True error of every edge, 2^-32 turn.
    errors: Vec<f64>,
}

impl Run {
    fn turned(&self) -> Turned {
        let mut noise = Noise(self.seed * 77 + 5);
        let size = TURN / self.edges as f64 / 50.0;
        let errors: Vec<f64> = (0..self.edges)
            .map(|_| (noise.next() * size).round())
            .collect();
        let mut steps = Vec::new();
        let mut swing = 0.0;
        for k in 0..=self.turns * self.edges {
            let edge = match self.direction {
                Direction::Forward => k % self.edges,
                Direction::Reverse => (self.edges - k % self.edges) % self.edges,
            };
            let sign = f64::from(self.direction.sign());
            let angle = k as f64 / self.edges as f64 - sign * errors[edge] / TURN;
            swing = 0.999 * swing + self.swing * noise.next();
            // Ticks of a turn: 10^7, less by a drift.
            let ticks = 1e7 * (angle - self.drift * angle * angle / 2.0 + swing) + 1e6;
            steps.push(Step {
                ticks: ticks.round() as u64,
                edge: edge as u32,
                position: edge as u32,
                interval: 1000,
                resync: 0,
                advance: 1,
                flags: Flags::REFERENCED,
                direction: self.direction,
            });
        }
        Turned { steps, errors }
    }
}

/// Way from edge to edge with a table.
fn ways(turned: &Turned, table: &[f64]) -> Vec<i32> {
    let edges = table.len() as u64;
    let angle = |step: &Step| {
        let grid = (u64::from(step.edge) << 32).checked_div(edges).unwrap();
        (grid as u32).wrapping_sub(table[step.edge as usize] as i32 as u32)
    };
    let mut last = angle(&turned.steps[0]);
    let way = |step: &Step| {
        let angle = angle(step);
        angle
            .wrapping_sub(std::mem::replace(&mut last, angle))
            .cast_signed()
    };
    turned.steps.iter().map(way).collect()
}

fn prove(turned: &Turned, old: &[f64], new: &[f64]) -> Figures {
    let shape = EncoderShape::new(old.len() as u32, 4).unwrap();
    let mut proof = Proof::new(shape);
    let edge = |moved: i32| Corrected {
        moved: TurnDelta32(moved),
        late: TickDelta8::ZERO,
    };
    for ((step, old), new) in turned
        .steps
        .iter()
        .zip(ways(turned, old))
        .zip(ways(turned, new))
    {
        proof.push(step, edge(old), edge(new));
        proof.settle();
    }
    proof.figures()
}

/// Mean square of what is left of `values` about the best polynomial of a degree.
fn left(values: &[f64], degree: usize) -> f64 {
    let n = values.len();
    let x = |k: usize| 2.0 * (k as f64 + 0.5) / n as f64 - 1.0;
    let mut rest = values.to_vec();
    let mut basis: Vec<Vec<f64>> = Vec::new();
    for power in 0..=degree {
        let mut column: Vec<f64> = (0..n).map(|k| x(k).powi(power as i32)).collect();
        // Twice, for what rounding leaves.
        for _ in 0..2 {
            for other in &basis {
                let dot: f64 = column.iter().zip(other).map(|(a, b)| a * b).sum();
                column
                    .iter_mut()
                    .zip(other)
                    .for_each(|(a, b)| *a -= dot * b);
            }
        }
        let norm = column.iter().map(|a| a * a).sum::<f64>().sqrt();
        column.iter_mut().for_each(|a| *a /= norm);
        let dot: f64 = rest.iter().zip(&column).map(|(a, b)| a * b).sum();
        rest.iter_mut()
            .zip(&column)
            .for_each(|(a, b)| *a -= dot * b);
        basis.push(column);
    }
    rest.iter().map(|a| a * a).sum::<f64>() / n as f64
}

/// The module's head in double precision: RMS of intervals and of angles.
fn reference(turned: &Turned, table: &[f64]) -> [f64; 2] {
    let n = table.len();
    let ways = ways(turned, table);
    let (mut interval, mut angle, mut turns) = (0.0, 0.0, 0.0);
    for turn in 1..(turned.steps.len() - 1) / n {
        let start = turn * n;
        let time = |k: usize| turned.steps[k].ticks as f64;
        let before = time(start) - time(start - n);
        let mut way = 0.0;
        let mut off = Vec::from([0.0]);
        for (k, moved) in ways.iter().enumerate().skip(start + 1).take(n) {
            way += f64::from(moved * turned.steps[k].direction.sign());
            off.push((time(k) - time(start)) / before * TURN - way);
        }
        let steps: Vec<f64> = off.windows(2).map(|pair| pair[1] - pair[0]).collect();
        interval += left(&steps, 1);
        angle += left(&off[1..], 2);
        turns += 1.0;
    }
    [interval, angle].map(|sum: f64| (sum / turns).sqrt())
}

#[test]
fn figures_agree_with_double_precision() {
    let run = |edges, drift, swing, seed, direction| Run {
        edges,
        turns: 6,
        drift,
        swing,
        seed,
        direction,
    };
    for run in [
        run(12, 0.0, 0.0, 1, Direction::Forward),
        run(240, 0.003, 1e-6, 2, Direction::Forward),
        run(1440, -0.006, 3e-6, 3, Direction::Reverse),
        run(10_000, 0.004, 1e-7, 4, Direction::Forward),
        run(65_536, 0.0, 1e-8, 5, Direction::Forward),
    ] {
        let turned = run.turned();
        let none = std::vec![0.0; run.edges];
        let figures = prove(&turned, &none, &turned.errors);
        assert_eq!((figures.turns, figures.rejected), (5, 0));
        for (table, scatter) in [(&none, figures.old), (&turned.errors, figures.new)] {
            let expected = reference(&turned, table);
            for (found, expected) in [scatter.interval, scatter.angle].into_iter().zip(expected) {
                let off = (f64::from(found) - expected).abs();
                // Times are cut to 2^-31 turn, which adds little more than its own size.
                assert!(
                    off < 2.0 + expected * 1e-4,
                    "{}: {found} {expected}",
                    run.edges
                );
            }
        }
        assert!(figures.better);
    }
}

#[test]
fn turns_that_the_main_loop_has_no_time_for_are_passed_over() {
    let shape = EncoderShape::new(4, 4).unwrap();
    let mut proof = Proof::new(shape);
    let edge = Corrected {
        moved: TurnDelta32(1 << 30),
        late: TickDelta8::ZERO,
    };
    let run = Run {
        edges: 4,
        turns: 9,
        drift: 0.0,
        swing: 0.0,
        seed: 1,
        direction: Direction::Forward,
    };
    for (step, k) in run.turned().steps.iter().zip(0..) {
        proof.push(step, edge, edge);
        if k == 20 {
            proof.settle();
        }
    }
    assert_eq!(proof.figures().turns, 1);
    proof.settle();
    proof.settle();
    assert_eq!((proof.figures().turns, proof.figures().rejected), (2, 0));
}

#[test]
fn only_what_is_better_for_certain_is_better() {
    let run = |swing, seed| Run {
        edges: 240,
        turns: 9,
        drift: 0.001,
        swing,
        seed,
        direction: Direction::Forward,
    };
    let mut won_by_chance = 0;
    for seed in 1..=200 {
        let turned = run(1e-5, seed).turned();
        let truth = &turned.errors;
        let none = std::vec![0.0; 240];
        let part = |share: f64| -> Vec<f64> { truth.iter().map(|e| (e * share).round()).collect() };
        let mut noise = Noise(seed + 999);
        let noisy: Vec<f64> = truth
            .iter()
            .map(|e| e + (noise.next() * 1e4).round())
            .collect();
        assert!(prove(&turned, &none, truth).better);
        assert!(prove(&turned, &part(0.8), truth).better);
        assert!(!prove(&turned, truth, truth).better);
        assert!(!prove(&turned, truth, &none).better);
        assert!(!prove(&turned, truth, &part(0.9)).better);
        // Two tables just as good, off by chance.
        let mut other = Noise(seed + 5555);
        let as_good: Vec<f64> = truth
            .iter()
            .map(|e| e + (other.next() * 1e4).round())
            .collect();
        won_by_chance += u32::from(prove(&turned, &noisy, &as_good).better);
    }
    assert!(won_by_chance < 20, "{won_by_chance}");
}

#[test]
fn a_smoother_speed_does_not_make_up_for_an_angle_that_is_worse() {
    let run = Run {
        edges: 1440,
        turns: 9,
        drift: 0.0,
        swing: 1e-7,
        seed: 3,
        direction: Direction::Forward,
    };
    let turned = run.turned();
    let none = std::vec![0.0; 1440];
    // A swing of the third order, twenty times the edges' own errors, hardly changes from edge to edge.
    let swung: Vec<f64> = turned
        .errors
        .iter()
        .enumerate()
        .map(|(k, e)| {
            let order = 3.0 * std::f64::consts::TAU * k as f64 / 1440.0;
            (e + 20.0 * TURN / 1440.0 / 50.0 * order.sin()).round()
        })
        .collect();
    let figures = prove(&turned, &none, &swung);
    assert!(figures.new.interval < figures.old.interval && figures.new.angle > figures.old.angle);
    assert!(!figures.better);
}

#[test]
fn a_disc_that_was_mounted_anew_shows_in_the_angle() {
    let run = Run {
        edges: 1440,
        turns: 9,
        drift: 0.001,
        swing: 1e-7,
        seed: 4,
        direction: Direction::Forward,
    };
    let turned = run.turned();
    // The table in use has all but the new eccentricity, a fifth of a step.
    let before: Vec<f64> = (0..1440)
        .zip(&turned.errors)
        .map(|(k, e)| {
            let order = std::f64::consts::TAU * f64::from(k) / 1440.0;
            (e + TURN / 1440.0 / 5.0 * order.sin()).round()
        })
        .collect();
    let figures = prove(&turned, &before, &turned.errors);
    assert!(figures.new.angle * 3 < figures.old.angle);
    assert!(figures.better);
    assert!(!prove(&turned, &turned.errors, &before).better);
}

#[test]
fn turns_with_an_edge_that_is_wrong_are_left_out() {
    let run = Run {
        edges: 240,
        turns: 12,
        drift: 0.0,
        swing: 1e-7,
        seed: 8,
        direction: Direction::Forward,
    };
    let mut turned = run.turned();
    let none = std::vec![0.0; 240];
    turned.steps[3 * 240 + 17].flags = Flags::REFERENCED.with(Flags::SPIKE);
    // The shaft stands still for a while.
    for step in &mut turned.steps[7 * 240 + 100..] {
        step.ticks += 3_000_000;
    }
    let figures = prove(&turned, &none, &turned.errors);
    // Of 12 turns the first has none before it; after each of the two left out one more has not.
    assert_eq!((figures.turns, figures.rejected), (7, 2));
    assert!(figures.new.interval < figures.old.interval / 20);
}
