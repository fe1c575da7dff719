//! A recording that was never made: simulated with the mechanism that was found, and with each look-alike in its place, and weighed
//! together with the recordings that there are.

use nalgebra::DMatrix;

use super::candidates::Candidate;
use crate::diagnose::basis::Basis;
use crate::diagnose::board::{Board, Column};
use crate::diagnose::estimate::Estimate;
use crate::diagnose::hypothesis::Hypothesis;
use crate::diagnose::instants::Between;
use crate::diagnose::mended::{self, Mended};
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
    /// The recordings against twins with all other findings in.
    board: Board,
    /// The first twin, with all other findings in and the noise that was found.
    twin: Twin,
    /// The finding, and what looks like it.
    rivals: Vec<Rival>,
    /// Columns of the speed, which is nobody's finding.
    nuisances: Vec<Column>,
}

/// One of those that look alike.
#[derive(Debug)]
struct Rival {
    hypothesis: Hypothesis,
    /// Its columns in the recordings that there are.
    columns: Vec<Column>,
    /// The twin with it in.
    twin: Twin,
}

impl<'a> Rehearsal<'a> {
    /// For a finding by its number; none where the look-alikes can't be put into a twin.
    #[must_use]
    pub fn of(rig: &'a [Recorded], settled: &Settled, number: usize) -> Option<Self> {
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
        let first = board.benches.first()?;
        let tick_s = rig.first()?.track.tick_s;
        let mut twin = in_noise(twins.first()?, &first.law, first.noise, tick_s);
        // The disc is the same with another seed.
        if twin.errors.position.is_some() {
            twin.errors.seed = twin.errors.seed.or(Some(twin.seed));
        }
        twin.faults = Faults::default();
        twin.timer.bits = 64;
        twin.timer.raw_captures = false;
        let mut rehearsal = Self {
            rig,
            nuisances: board.nuisances().into_iter().map(Column::kept).collect(),
            board,
            twin,
            rivals: Vec::new(),
        };
        let own = settled.estimates.get(number)?;
        rehearsal.add(own.hypothesis.clone(), Some(own.sizes.clone()))?;
        for rival in &settled.concluded.named.get(number)?.look_alikes {
            rehearsal.add(placed(rival), None)?;
        }
        Some(rehearsal)
    }

    /// Adds a rival with sizes, or those that fit the recordings best.
    fn add(&mut self, hypothesis: Hypothesis, sizes: Option<Vec<f64>>) -> Option<()> {
        let columns: Vec<Column> = hypothesis
            .columns(&self.board)
            .into_iter()
            .map(Column::kept)
            .collect();
        let sizes = match sizes {
            Some(sizes) => sizes,
            None => {
                let all = self.nuisances.iter().chain(&columns).cloned().collect();
                let model = self.board.fit(all)?;
                model.sizes.as_slice()[self.nuisances.len()..].to_vec()
            }
        };
        let count = sizes.len();
        let estimate = Estimate {
            hypothesis: hypothesis.clone(),
            sizes,
            searched: Vec::new(),
            covariance: DMatrix::zeros(count, count),
            between: Between::default(),
        };
        let mut mended = Mended {
            twin: self.twin.clone(),
            errors_rad: Vec::new(),
            edges: self.board.benches[0].seen.edges as usize,
            classes: self.board.benches[0].seen.classes as usize,
        };
        mended.add(&estimate, 0, self.rig.len());
        mended.list(&self.board.benches[0].seen.errors);
        self.rivals.push(Rival {
            hypothesis,
            columns,
            twin: mended.twin,
        });
        Some(())
    }

    /// Mechanisms that are weighed, that of the finding first.
    pub fn mechanisms(&self) -> impl Iterator<Item = Mechanism> + '_ {
        self.rivals.iter().map(|rival| rival.hypothesis.mechanism)
    }

    /// By how much the best of the others is worse by Schwarz's criterion if one of them, by its number, makes the recording; none
    /// where the recording can't be simulated or weighed.
    #[must_use]
    pub fn difference(&self, candidate: &Candidate, truth: usize) -> Option<f64> {
        let board = self.with(candidate, truth)?;
        let nuisances = self.joined(&board, &self.nuisances, |new| new.nuisances());
        let model = board.fit(nuisances)?;
        let score = |rival: &Rival| {
            let joined = self.of_hypothesis(&board, rival);
            let weighed = weigh(&board, &model, rival.hypothesis.clone(), joined);
            weighed.map(|weighed| weighed.score)
        };
        let own = score(self.rivals.get(truth)?)?;
        let name = self.rivals[truth].hypothesis.mechanism;
        let others = self
            .rivals
            .iter()
            .filter(|r| r.hypothesis.mechanism != name);
        let best = others.filter_map(score).reduce(f64::max)?;
        Some(own - best)
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

    /// A hypothesis' columns in all recordings: of those that there are they are known.
    fn of_hypothesis(&self, board: &Board, rival: &Rival) -> Vec<Column> {
        let mut at = 0;
        let each = rival.hypothesis.bases.iter().flat_map(|basis| {
            let own = own(*basis, self.board.tied);
            let count = basis.count() * if own { self.board.benches.len() } else { 1 };
            let known = rival.columns.get(at..at + count).unwrap_or_default();
            at += count;
            let new = |new: &Board| new.columns(*basis);
            if own {
                self.joined(board, known, new)
            } else {
                let parts = new(&self.last(board)).into_iter();
                let pairs = known.iter().cloned().zip(parts);
                pairs
                    .map(|(mut known, new)| {
                        known.0.extend(new.0);
                        known
                    })
                    .collect()
            }
        });
        each.collect()
    }

    /// Columns of the recordings that there are, and columns of the new one's own.
    fn joined(
        &self,
        board: &Board,
        known: &[Column],
        new: impl Fn(&Board) -> Vec<Column>,
    ) -> Vec<Column> {
        let count = self.board.benches.len();
        let padded = known.iter().cloned().map(|mut column| {
            column.0.push(None);
            column
        });
        let own = new(&self.last(board)).into_iter().map(|column| {
            let mut all = vec![None; count];
            all.extend(column.0);
            Column(all)
        });
        padded.chain(own).collect()
    }

    /// The new recording alone.
    fn last(&self, board: &Board) -> Board {
        Board {
            benches: board.benches.last().cloned().into_iter().collect(),
            tied: board.tied,
            clear: std::sync::OnceLock::new(),
            products: board.products.clone(),
        }
    }
}

/// Whether each of several recordings has a size of its own, as in [`Board::raw_columns`].
const fn own(basis: Basis, tied: bool) -> bool {
    basis.timed() || (basis.placed() && !tied)
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
