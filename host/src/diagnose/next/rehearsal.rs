//! A recording that was never made: simulated with the mechanism that was found, and with each look-alike in its place, and weighed
//! together with the recordings that there are.
//!
//! Other findings stay in the twin, but not at their sizes: what looks like one finding may do so only with another one changed, as a
//! width error of A looks like a delay of its rises where B lies off by as much. So whatever is weighed is weighed beside all of them,
//! and beside what looks like them, with every size free.

use nalgebra::DMatrix;

use super::candidates::Candidate;
use super::extended::{Known, nuisances};
use crate::diagnose::basis::Basis;
use crate::diagnose::board::{Board, Column, Model};
use crate::diagnose::estimate::Estimate;
use crate::diagnose::hypothesis::Hypothesis;
use crate::diagnose::instants::Between;
use crate::diagnose::mended;
use crate::diagnose::run::Recorded;
use crate::diagnose::settle::Settled;
use crate::diagnose::still::simulators;
use crate::diagnose::torques::in_noise;
use crate::diagnose::track::Track;
use crate::diagnose::weigh::weigh;
use crate::diagnose::{bench::Bench, prepare};
use crate::mechanism::Mechanism;
use crate::sensor::PlanError;
use crate::sim::Simulation;
use crate::twin::{Faults, Twin};

/// Everything that a rehearsal needs of what was settled.
#[derive(Debug)]
pub struct Rehearsal<'a> {
    rig: &'a [Recorded],
    settled: &'a Settled,
    /// The recordings against twins with all other findings in.
    board: Board,
    /// The first twin, with all other findings in and the noise that was found.
    twin: Twin,
    /// The finding, and what looks like it.
    rivals: Vec<Rival>,
    /// The other findings.
    others: Vec<Estimate>,
    /// The same as patterns, and what looks like them.
    beside: Vec<Known>,
    /// Columns of the speed, which is nobody's finding.
    nuisances: Vec<Column>,
}

/// One of those that look alike.
#[derive(Debug)]
struct Rival {
    known: Known,
    /// The twin with it in.
    twin: Twin,
}

impl<'a> Rehearsal<'a> {
    /// For a finding by its number; none where the look-alikes can't be put into a twin.
    #[must_use]
    pub fn of(rig: &'a [Recorded], settled: &'a Settled, number: usize) -> Option<Self> {
        let name = settled.concluded.named.get(number)?;
        let others: Vec<Estimate> = settled
            .estimates
            .iter()
            .enumerate()
            .filter(|(at, _)| *at != number)
            .map(|(_, estimate)| estimate.clone())
            .collect();
        let (twins, _) = mended::twins(rig, &settled.given, settled.pattern.as_ref(), &others);
        let mut board = prepare::board(&mended::with_twins(rig, &twins)).ok()?;
        for (bench, given) in board.benches.iter_mut().zip(&settled.given.benches) {
            bench.set_noise(given.noise);
        }
        let mut beside: Vec<Known> = Vec::new();
        for other in &others {
            beside.push(Known::of(other.hypothesis.clone(), &board));
        }
        let named = settled.concluded.named.iter().enumerate();
        let alike = named.filter(|(at, _)| *at != number);
        for hypothesis in alike.flat_map(|(_, other)| &other.look_alikes) {
            // What is weighed itself is no way out for the others.
            let mechanism = hypothesis.mechanism;
            let weighed = mechanism == name.hypothesis.mechanism
                || name.look_alikes.iter().any(|l| l.mechanism == mechanism);
            if !weighed {
                beside.push(Known::of(hypothesis.clone(), &board));
            }
        }
        let mut rehearsal = Self {
            rig,
            settled,
            nuisances: board.nuisances().into_iter().map(Column::kept).collect(),
            twin: noisy(rig, &board, twins.first()?)?,
            board,
            rivals: Vec::new(),
            others,
            beside,
        };
        let own = settled.estimates.get(number)?;
        let known = Known::of(own.hypothesis.clone(), &rehearsal.board);
        rehearsal.add(known, own.sizes.clone(), rehearsal.others.clone())?;
        for rival in &name.look_alikes {
            let known = Known::of(placed(rival), &rehearsal.board);
            let (sizes, others) = rehearsal.sized(&known)?;
            rehearsal.add(known, sizes, others)?;
        }
        Some(rehearsal)
    }

    /// Sizes of a rival that fit the recordings best, and the other findings beside it.
    fn sized(&self, known: &Known) -> Option<(Vec<f64>, Vec<Estimate>)> {
        let first = self.nuisances.len();
        let own = first + known.columns.len();
        let mut columns: Vec<Column> = self.nuisances.clone();
        columns.extend(known.columns.iter().cloned());
        let mut model = self.board.fit(columns.clone())?;
        let mut others = self.others.clone();
        let mut moved = Vec::new();
        for (number, other) in self.beside.iter().enumerate().take(others.len()) {
            let mut more = columns.clone();
            more.extend(other.columns.iter().cloned());
            if let Some(fitted) = self.board.fit(more.clone()) {
                moved.push((number, columns.len()..more.len()));
                (columns, model) = (more, fitted);
            }
        }
        let sizes = model.sizes.as_slice();
        for (number, range) in moved {
            for (size, more) in others[number].sizes.iter_mut().zip(&sizes[range]) {
                *size += more;
            }
        }
        Some((sizes[first..own].to_vec(), others))
    }

    /// Adds a rival with sizes, and with the other findings as they are beside it.
    fn add(&mut self, known: Known, sizes: Vec<f64>, others: Vec<Estimate>) -> Option<()> {
        let count = sizes.len();
        let mut all = others;
        all.push(Estimate {
            hypothesis: known.hypothesis.clone(),
            sizes,
            searched: Vec::new(),
            covariance: DMatrix::zeros(count, count),
            between: Between::default(),
        });
        let pattern = self.settled.pattern.as_ref();
        let (twins, _) = mended::twins(self.rig, &self.settled.given, pattern, &all);
        let twin = noisy(self.rig, &self.board, twins.first()?)?;
        self.rivals.push(Rival { known, twin });
        Some(())
    }

    /// Mechanisms that are weighed, that of the finding first.
    pub fn mechanisms(&self) -> impl Iterator<Item = Mechanism> + '_ {
        self.rivals.iter().map(Rival::mechanism)
    }

    /// By how much the best of the others is worse by Schwarz's criterion if one of them, by its number, makes the recording; none
    /// where the recording can't be simulated or weighed.
    #[must_use]
    pub fn difference(&self, candidate: &Candidate, truth: usize) -> Option<f64> {
        let board = self.with(candidate, truth)?;
        let model = self.free(&board)?;
        let score = |rival: &Rival| {
            let columns = rival.known.extended(&board);
            let weighed = weigh(&board, &model, rival.known.hypothesis.clone(), columns);
            weighed.map(|weighed| weighed.score)
        };
        let own = score(self.rivals.get(truth)?)?;
        let name = self.rivals[truth].mechanism();
        let others = self.rivals.iter().filter(|r| r.mechanism() != name);
        let best = others.filter_map(score).reduce(f64::max)?;
        Some(own - best)
    }

    /// Everything beside the rivals, as far as it can be told apart.
    fn free(&self, board: &Board) -> Option<Model> {
        let mut model = board.fit(nuisances(&self.nuisances, board))?;
        for column in self.beside.iter().flat_map(|other| other.extended(board)) {
            if board.gain(&model, std::slice::from_ref(&column)).is_none() {
                continue;
            }
            let mut more = model.columns.clone();
            more.push(column);
            if let Some(fitted) = board.fit(more) {
                model = fitted;
            }
        }
        Some(model)
    }

    /// The recordings and the simulated one.
    fn with(&self, candidate: &Candidate, truth: usize) -> Option<Board> {
        let driven = |twin: &Twin, seed: u64| Twin {
            seed,
            drive: candidate.drive.clone(),
            duration: candidate.duration,
            ..twin.clone()
        };
        let plan = simulators(self.rig.first()?.plan);
        let rival = self.rivals.get(truth)?;
        let truth = driven(&rival.twin, self.twin.seed.wrapping_add(1) >> 1);
        let rows = Simulation::new(&truth).ok()?;
        let rows = rows.map(|event| Ok::<_, PlanError>(event.row));
        let recorded = Recorded {
            file: String::new(),
            plan,
            track: Track::of(plan, truth.timer.clock_hz, rows).ok()?,
            twin: driven(&self.twin, 0),
        };
        let mut board = self.board.clone();
        let new: Bench = prepare::bench(&recorded).ok()?;
        board.benches.push(new);
        Some(board)
    }
}

impl Rival {
    const fn mechanism(&self) -> Mechanism {
        self.known.hypothesis.mechanism
    }
}

/// A twin of the first recording in the noise that was found, with a disc that is the same with another seed.
fn noisy(rig: &[Recorded], board: &Board, twin: &Twin) -> Option<Twin> {
    let first = board.benches.first()?;
    let mut twin = in_noise(twin, &first.law, first.noise, rig.first()?.track.tick_s);
    if twin.errors.position.is_some() {
        twin.errors.seed = twin.errors.seed.or(Some(twin.seed));
    }
    twin.faults = Faults::default();
    twin.timer.bits = 64;
    twin.timer.raw_captures = false;
    Some(twin)
}

/// The same with marks at the places of the grid, which a twin can have.
fn placed(hypothesis: &Hypothesis) -> Hypothesis {
    let bases = hypothesis.bases.iter().map(|basis| match *basis {
        Basis::Lagged { order } if order.fract() == 0.0 => Basis::Round { order },
        other => other,
    });
    Hypothesis {
        mechanism: hypothesis.mechanism,
        bases: bases.collect(),
    }
}
