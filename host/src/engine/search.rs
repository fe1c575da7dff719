//! One search: the best cell is added, all numbers are fitted together, what is no longer worth its numbers is dropped, until nothing
//! changes.

use super::cells;
use super::effect::{Carrier, Effect, Site};
use super::lsq::Basis;
use super::model::{Board, Fit, Model, Term};
use super::scan::{self, Candidate};

/// Findings at the most.
const FINDINGS: usize = 7;
/// Evidence that a finding needs beyond its numbers and the cells that were looked at: twice a difference of logarithms.
const SURE: f64 = 12.0;

/// Evidence of a candidate: what it explains, less what its numbers would by chance (G. Schwarz, Annals of Statistics 6, 1978).
#[must_use]
pub fn evidence(board: &Board, gain: f64, numbers: usize) -> f64 {
    gain - numbers as f64 * (board.edges() as f64).ln()
}

/// What nobody knows of any rig: the mean speed that an open-loop drive holds.
#[must_use]
pub fn nuisances(board: &Board) -> Model {
    let mut terms = Vec::new();
    let steady = board.benches.iter().any(|bench| {
        bench.plant.law.stiffness + bench.plant.law.viscous > 0.0 && bench.plant.law.mode.is_none()
    });
    if steady {
        terms.push(Term {
            effect: Effect::new(Site::Torque, Carrier::Steady),
            sizes: vec![0.0],
            nuisance: true,
            group: usize::MAX,
        });
    }
    Model { terms }
}

/// All candidates beside a fit, strongest first.
#[must_use]
pub fn candidates(board: &Board, fit: &Fit) -> Vec<Candidate> {
    use rayon::prelude::*;
    let sized: Vec<&[f64]> = fit.columns.iter().map(Vec::as_slice).collect();
    let basis = Basis::of(&sized);
    let mut fit = fit.clone();
    basis.clear(&mut fit.left);
    let fit = &fit;
    let mut all: Vec<Candidate> = cells::steady(board)
        .into_par_iter()
        .map(|effects| {
            let columns: Vec<Vec<f64>> = effects
                .iter()
                .flat_map(|effect| board.columns(effect))
                .collect();
            Candidate {
                gain: basis.gain(&columns, &fit.left),
                effects,
            }
        })
        .collect();
    all.extend(scan::spectra(board, fit, &basis));
    all.extend(cells::loads(board, fit, &basis));
    all.extend(cells::bumps(board, fit, &basis));
    all.sort_by(|a, b| {
        evidence(board, b.gain, b.numbers()).total_cmp(&evidence(board, a.gain, a.numbers()))
    });
    all
}

/// Searches until nothing is left that is worth its numbers.
#[must_use]
pub fn search(board: &mut Board) -> Fit {
    let mut model = nuisances(board);
    let mut fit = board.fit(&model);
    let mut groups = 0;
    while groups < FINDINGS {
        let mut found = candidates(board, &fit);
        found.truncate(6);
        // The best few, fitted with everything else.
        let mut best: Option<(f64, Fit)> = None;
        for candidate in found {
            if evidence(board, candidate.gain, candidate.numbers()) < 0.5 * SURE {
                continue;
            }
            let mut terms = fit.model.terms.clone();
            terms.extend(candidate.effects.iter().map(|effect| Term {
                effect: *effect,
                sizes: vec![0.0; effect.sizes()],
                nuisance: false,
                group: groups,
            }));
            let tried = board.fit(&Model { terms });
            let here = evidence(board, fit.rss - tried.rss, candidate.numbers());
            if std::env::var("ENGINE_TRACE").is_ok() {
                println!(
                    "   try {:?} gain {:.1} fitted {:.1} evidence {here:.1}",
                    candidate.effects,
                    candidate.gain,
                    fit.rss - tried.rss
                );
            }
            if here > SURE && best.as_ref().is_none_or(|(most, _)| here > *most) {
                best = Some((here, tried));
            }
        }
        let Some((_, next)) = best else { break };
        groups += 1;
        board.fit_noise(&next.model);
        fit = board.fit(&next.model);
        // What another one has made superfluous.
        model = dropped(board, &fit);
        if model.terms.len() < fit.model.terms.len() {
            fit = board.fit(&model);
        }
    }
    fit
}

/// A model without groups that are no longer worth their numbers.
fn dropped(board: &Board, fit: &Fit) -> Model {
    let mut model = fit.model.clone();
    let mut groups: Vec<usize> = model
        .terms
        .iter()
        .filter(|term| !term.nuisance)
        .map(|term| term.group)
        .collect();
    groups.dedup();
    for group in groups {
        if evidence(board, fit.loss(group), model.numbers(group)) < SURE {
            model.terms.retain(|term| term.group != group);
            return model;
        }
    }
    model
}
