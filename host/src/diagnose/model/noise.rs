//! The noise of a board: its size beside a model, how likely that makes the recordings, and which kinds of it there may be.

use std::f64::consts::TAU;

use rayon::prelude::*;

use super::board::{BOTH, COMPARED, SIZED};
use super::{Board, Fit, Model};
use crate::diagnose::bench::{self, Bench};
use crate::diagnose::corners::Corner;
use crate::diagnose::course::Course;
use crate::diagnose::diagnosis::LearnedRinging;
use crate::diagnose::effect::Carrier;
use crate::diagnose::filter::{Noise, Ring};
use crate::diagnose::lsq;
use crate::diagnose::noise::{Free, Tails};
use crate::diagnose::pattern::Pattern;
use crate::diagnose::scan::{SURE, Spectrum, local_median};

/// What else there may be to noise, and where a fit of it begins: how long a torque that wanders lasts, or a mode that rings.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Wander {
    /// About a turn.
    Quick,
    /// Far longer than the recordings: of a drive that nobody declared, what its corners leave stays.
    Lasting,
    /// None; a mode of the machine.
    Ringing(Ring),
}

/// Part of a drift that lasts that fades while the longest recording does: a corner may be a million times as large as the noise beside it.
const LASTING: f64 = 1e-6;

/// Numbers of a mode that rings.
const RINGS: usize = 4;
/// How much a mode is damped where a fit of it begins, of its rate.
const DAMPED: f64 = 0.1;

/// Whether a size of the noise has hardly changed.
fn is_alike(was: f64, is: f64) -> bool {
    (is / was.max(f64::MIN_POSITIVE)).ln().abs() < 0.05
}

impl Board {
    /// Sets the disc's pattern to the size of most evidence beside a model, and the noise to what both leave, as long as that makes the
    /// recordings likelier, as each bears on the other. The model's fit in it.
    pub fn size_up(&mut self, model: &Model) -> Fit {
        let mut fit = self.fit(model);
        let mut lost = self.lost(&fit);
        for _ in 0..self.rounds {
            let mut next = self.clone();
            next.size_once(&fit.model);
            let other = next.fit(&fit.model);
            let less = next.lost(&other);
            if less >= lost {
                break;
            }
            let (was, is) = (self.noise, next.noise);
            (*self, fit, lost) = (next, other, less);
            if is_alike(was.torque, is.torque) && is_alike(was.stamp_s, is.stamp_s) {
                break;
            }
        }
        fit
    }

    /// The same once.
    fn size_once(&mut self, model: &Model) {
        let Some(mut pattern) = self.pattern.take() else {
            return;
        };
        let mut left = self.rest(model);
        let white = self.white(&left);
        pattern.size_up(&self.benches, &white);
        let errors = pattern.closest(&self.benches, &white);
        for (bench, left) in self.benches.iter().zip(&mut left) {
            bench.less_errors(left, &errors);
        }
        let noise = self.levelled(&left);
        self.pattern = Some(pattern);
        self.set_noise(noise);
        self.go_by(model);
    }

    /// Fits the noise to what a model leaves.
    pub fn fit_noise(&mut self, model: &Model) {
        if self.pattern.is_some() {
            self.size_up(model);
            return;
        }
        let rest = self.rest(model);
        for _ in 0..BOTH {
            let (before, noise) = (self.noise, self.levelled(&rest));
            self.set_noise(noise);
            if is_alike(before.torque, noise.torque) {
                break;
            }
        }
    }

    /// Fits the noise to what a model leaves, and the model in it.
    pub fn fit_in_noise(&mut self, model: &Model) -> Fit {
        if self.pattern.is_some() {
            return self.size_up(model);
        }
        self.fit_noise(model);
        self.fit(model)
    }

    /// A model beside the noise that it leaves: the board, the fit, and its [`Self::lost`].
    #[must_use]
    pub fn at_its_noise(&self, model: &Model) -> (Self, Fit, f64) {
        let mut board = self.clone();
        let mut fit = board.fit(model);
        for _ in 0..BOTH {
            let before = board.noise.torque;
            fit = board.fit_in_noise(&fit.model);
            // A pattern is sized up until neither changes.
            if board.pattern.is_some() || is_alike(before, board.noise.torque) {
                break;
            }
        }
        let lost = board.lost(&fit);
        (board, fit, lost)
    }

    /// Twice the negative logarithm of the likelihood of a fit, with what its numbers would gain by chance.
    pub fn lost(&self, fit: &Fit) -> f64 {
        let scales = self.benches.iter().flat_map(|bench| &bench.scales);
        let scales = scales.filter(|scale| **scale > 0.0);
        let weights = self.benches.iter().flat_map(|bench| &bench.weights);
        let weights: f64 = weights.map(|weight| weight.ln()).sum();
        let volume = self.pattern.as_ref().map_or(0.0, Pattern::log_volume);
        let groups = fit.model.groups().into_iter();
        let numbers: usize = groups.map(|group| fit.model.numbers(group)).sum();
        let corners = self.benches.iter().map(|bench| bench.found.corners.len());
        let numbers = numbers + Corner::NUMBERS * corners.sum::<usize>();
        let numbers = numbers + if self.free.ring { RINGS } else { 0 };
        let chance = numbers as f64 * (self.edges() as f64).ln();
        let scales: f64 = scales.map(|scale| scale.ln()).sum();
        self.squares(fit) + volume + chance - 2.0 * (scales + weights)
    }

    /// Twice the negative logarithm of how likely innovations of a fit are, over their deviations.
    fn squares(&self, fit: &Fit) -> f64 {
        let tails = self.free.tails;
        if tails == Tails::Normal {
            return fit.rss;
        }
        let (edges, disc) = fit.left.split_at(self.edges());
        let scales = self.benches.iter().flat_map(|bench| &bench.scales);
        let weights = self.benches.iter().flat_map(|bench| &bench.tails);
        let each = edges.iter().zip(weights).zip(scales);
        let shown = each.filter(|(_, scale)| **scale > 0.0);
        shown
            .map(|((white, weight), _)| tails.cost(white / weight))
            .sum::<f64>()
            + lsq::dot(disc, disc)
    }

    /// Weighs edges by the level of the noise about them, and by how far out they are. The noise that fits so.
    fn levelled(&mut self, rest: &[Vec<f64>]) -> Noise {
        let (levels, tails) = (self.levels, self.free.tails);
        let each = self.benches.par_iter_mut().zip(rest);
        each.for_each(|(bench, rest)| {
            if levels {
                bench.level(rest);
            }
            bench.weigh(rest, tails);
        });
        bench::fit_noise(&self.benches, rest, self.noise, self.free).0
    }

    /// The same board in white and normal noise.
    #[must_use]
    pub fn in_plain_noise(&self) -> Self {
        let mut board = self.clone();
        board.levels = false;
        board.rounds = SIZED;
        board.free = Free {
            drift: board.undriven,
            fast: false,
            fade: false,
            ring: false,
            tails: Tails::Normal,
            ..board.free
        };
        for bench in &mut board.benches {
            bench.weights.fill(1.0);
            bench.tails.fill(1.0);
        }
        if !board.undriven {
            board.noise.drift = 0.0;
        } else if board.noise.fade > 0.0 {
            // How dense one is that fades says nothing of one that does not: as dense as the torque noise once a turn.
            board.noise.drift = board.noise.torque * board.turning().powi(2);
        }
        board.noise.fade = 0.0;
        board.noise.ring = Ring::default();
        board.set_noise(board.noise);
        board
    }

    /// The same board with a torque noise that is held over an interval at some speed of the course, as drives and simulators make it; none
    /// where the twins say how long it is held.
    #[must_use]
    pub fn in_held_noise(&self, speed: fn(&Course) -> f64) -> Option<Self> {
        let mut board = self.clone();
        for bench in &mut board.benches {
            if bench.plant.law.hold_s > 0.0 {
                return None;
            }
            let turn_s = std::f64::consts::TAU / speed(&bench.course);
            bench.hold_noise(turn_s / bench.record.of_edges as f64);
        }
        board.set_noise(board.noise);
        Some(board)
    }

    /// The same board in noise as rigs have it: with a torque that wanders, with levels and, as asked for, with long tails.
    #[must_use]
    pub fn in_any_noise(&self, tails: Tails, wander: Wander) -> Self {
        let mut board = self.clone();
        board.levels = true;
        board.rounds = COMPARED;
        board.free.tails = tails;
        if let Wander::Ringing(ring) = wander {
            board.free.ring = true;
            board.set_noise(Noise {
                ring,
                ..board.noise
            });
            return board;
        }
        board.free = Free {
            drift: true,
            fast: true,
            fade: true,
            ..board.free
        };
        if board.noise.fade <= 0.0 {
            board.set_noise(board.fading(wander));
        }
        board
    }

    /// Where a mode may ring that nothing has found yet: where most of what innovations have more of than white ones is near one frequency.
    /// Medians are not those of lines. What rings makes up tones and sweeps alone: where none was found there is none to judge.
    pub fn may_ring(&self, fit: &Fit) -> Option<Ring> {
        let sprung = |bench: &Bench| bench.plant.law.mode.is_some();
        let mut terms = fit.model.terms.iter().filter(|term| !term.nuisance);
        let rhythm =
            terms.any(|term| matches!(term.effect.carrier, Carrier::Tone(_) | Carrier::Chirp(..)));
        if !rhythm || self.free.ring || self.benches.iter().any(sprung) {
            return None;
        }
        let each = bench::parts(&self.benches, &fit.left);
        let each = each.map(|(bench, left)| Spectrum {
            values: left.to_vec(),
            along: bench.record.time_s.clone(),
            unit: 1.0,
        });
        let each: Vec<Spectrum> = each.collect();
        let longest = each.iter().map(Spectrum::span).fold(0.0, f64::max);
        let step = 0.5 / longest;
        let fastest = each.iter().map(Spectrum::fastest).fold(0.0, f64::max);
        let mut power = vec![0.0; (fastest / step) as usize];
        for one in &each {
            let own = one.power(step, power.len());
            let unit = lsq::dot(&one.values, &one.values) * each.len() as f64;
            let own = own.iter().map(|own| own / unit);
            power.iter_mut().zip(own).for_each(|(sum, own)| *sum += own);
        }
        let floors = local_median(&power).into_iter().enumerate().skip(1);
        // What as many lines as a swing of that damping has are worth with that mean, each told by two points.
        let worth = |(at, floor): (usize, f64)| {
            let lines = DAMPED * at as f64 / 2.0;
            let worth = 2.0 * lines * (floor - 1.0 - floor.ln());
            (worth, at, floor)
        };
        let more = floors.filter(|(_, floor)| *floor > 1.0).map(worth);
        let (worth, at, floor) = more.max_by(|a, b| a.0.total_cmp(&b.0))?;
        let rate = TAU * step * at as f64;
        let damping = DAMPED * rate;
        (worth > SURE).then_some(Ring {
            // As large at its rate as the torque noise, so many times.
            density: (floor - 1.0) * self.noise.torque * DAMPED * DAMPED,
            rate,
            damping,
            shared: 0.0,
        })
    }

    /// What rings beside a drive that nobody declared, for a report.
    pub fn learned_ringing(&self) -> Option<LearnedRinging> {
        let Ring { rate, damping, .. } = self.noise.ring;
        (self.undriven && self.free.ring).then(|| LearnedRinging {
            f_hz: rate / TAU,
            damping_ratio: 0.5 * damping / rate,
        })
    }

    /// The noise with a drift that fades from now on.
    pub fn fading(&self, wander: Wander) -> Noise {
        match wander {
            // Three times as dense as the torque noise, to once a turn.
            Wander::Quick => Noise {
                drift: 3.0 * self.noise.torque * self.turning().powi(2),
                fade: self.turning(),
                ..self.noise
            },
            Wander::Ringing(ring) => Noise { ring, ..self.noise },
            Wander::Lasting => {
                let each = self.benches.iter().map(|bench| bench.record.seconds());
                Noise {
                    fade: LASTING / each.fold(0.0, f64::max),
                    ..self.noise
                }
            }
        }
    }

    /// Speed of the fastest recording, rad/s.
    fn turning(&self) -> f64 {
        let speed = self.benches.iter().map(|bench| bench.leaps.speed());
        speed.fold(0.0, f64::max)
    }

    /// Goes by another noise.
    pub fn set_noise(&mut self, noise: Noise) {
        self.noise = noise;
        self.benches
            .par_iter_mut()
            .for_each(|bench| bench.set_noise(&noise));
        if let Some(pattern) = &mut self.pattern {
            pattern.weigh(&self.benches);
        }
    }
}
