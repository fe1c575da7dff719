//! Look-alikes: what else a finding may be, fitted in its place beside everything else.

use super::cells::{self, Bank};
use super::effect::{Carrier, Effect, Site};
use super::model::{Board, Fit};
use super::name;
use super::search::{self, ALIKE, SURE, evidence};
use crate::mechanism::Mechanism;

/// Part of a finding's evidence that another cell has to have to be fitted in its place, how many are, and by how much a better one is.
const NEAR: f64 = 0.5;
const RIVALS: usize = 4;
const BETTER: f64 = 2.0;

/// Part of the evidence of a loud torque that its course between so few edges leaves open.
const AS_EXACT: f64 = 1e-4;

/// What a finding may be as well.
#[derive(Clone, Debug, Default)]
pub struct Alike {
    /// Its group.
    pub group: usize,
    /// Others with how much less evidence they have, least first.
    pub others: Vec<(Mechanism, f64)>,
    /// The same at other places: orders of which so few edges a turn show no difference.
    pub images: Vec<Effect>,
}

/// Puts a better explanation in the place of a finding where there is one, and lists those that are as good.
pub fn swapped(board: &mut Board, bank: &Bank, fit: &mut Fit) -> Vec<Alike> {
    let mut all = Vec::new();
    for group in fit.model.groups() {
        let own = fit.model.effects(group);
        let mechanism = board.mechanism(&own);
        let corrects = own.iter().any(|effect| board.correction(effect).is_some());
        // What the twin declares comes first.
        let better = if corrects { ALIKE } else { BETTER };
        let rest = fit.without(group);
        let basis = rest.basis();
        let worth = evidence(board, rest.rss - fit.rss, fit.model.numbers(group));
        // The best of each other name that comes near, fitted with everything else.
        let mut rivals: Vec<(Mechanism, f64, Vec<Effect>)> = Vec::new();
        let mut same: Vec<Mechanism> = Vec::new();
        for candidate in search::candidates(board, bank, &rest) {
            let here = search::worth(board, &candidate);
            let named = name::mechanism(&candidate.effects);
            let near = here > NEAR * worth - ALIKE;
            if !near || rivals.len() == RIVALS {
                break;
            }
            let is_same = corrects
                && (shows_in_sum(board, &own, &candidate.effects)
                    || board.same_columns(fit, group, &candidate.effects));
            // A number of the shaft or its drive is the name of no mechanism: what has the same columns is one.
            if is_same && mechanism == Mechanism::Unknown && !same.contains(&named) {
                same.push(named);
            }
            if is_same || search::joins(&rest.model, &candidate.effects).is_some() {
                continue;
            }
            if rivals.iter().all(|(other, ..)| *other != named) {
                let (effects, gain) = board.beside(&rest, &basis, &candidate.effects);
                let fitted = evidence(board, gain, candidate.numbers());
                rivals.push((named, fitted, effects));
            }
        }
        for effects in cells::grown(board, &own) {
            let (effects, gain) = board.beside(&rest, &basis, &effects);
            let numbers = fit.model.numbers(group) + effects.len();
            let fitted = evidence(board, gain, numbers);
            if fitted > worth + SURE {
                rivals.push((Mechanism::Unknown, fitted, effects));
            }
        }
        // An exact order is no number.
        if let Some(exact) = cells::synchronous(board, &own) {
            let gain = basis.gain(&board.columns(&exact), &rest.left);
            let named = name::mechanism(&[exact]);
            rivals.push((named, evidence(board, gain, exact.sizes()), vec![exact]));
        }
        let images = match own.as_slice() {
            [one] => board.images(one),
            _ => Vec::new(),
        };
        // Each at its exact place: the course may tell them apart by a speed's swing alone.
        let images = images.into_iter().map(|image| {
            let gain = basis.gain(&board.columns(&image), &rest.left);
            (evidence(board, gain, 2), image)
        });
        let images: Vec<(f64, Effect)> = images.collect();
        let open = ALIKE + AS_EXACT * worth;
        let best = images.iter().max_by(|a, b| a.0.total_cmp(&b.0));
        let best = best.filter(|(fitted, _)| *fitted > worth + open);
        rivals.extend(best.map(|(fitted, image)| (mechanism, *fitted, vec![*image])));
        let as_good = images.iter().filter(|(fitted, _)| *fitted > worth - open);
        let mut images: Vec<Effect> = as_good.map(|(_, image)| *image).collect();
        rivals.sort_by(|a, b| b.1.total_cmp(&a.1));
        let (mut worth, mut named) = (worth, mechanism);
        if rivals.first().is_some_and(|one| one.1 > worth + better) {
            let (other, best, effects) = rivals.swap_remove(0);
            if other != mechanism {
                rivals.push((mechanism, worth, own));
            }
            (named, worth) = (other, best);
            *fit = board.fit(&search::with(board, &rest.model, &effects, group));
            // What the twins leave open is no finding.
            if !fit.model.groups().contains(&group) {
                continue;
            }
            images.clear();
        }
        rivals.retain(|(other, ..)| !same.contains(other));
        let others = rivals.iter().map(|(other, here, _)| (*other, worth - here));
        let same = same.into_iter().map(|other| (other, 0.0));
        let mut others: Vec<(Mechanism, f64)> = others.chain(same).collect();
        others.retain(|(other, less)| {
            *other != named && *other != Mechanism::Unknown && *less < ALIKE
        });
        others.sort_by(|a, b| a.1.total_cmp(&b.1));
        all.push(Alike {
            group,
            others,
            images,
        });
    }
    *fit = board.fit_in_noise(&fit.model);
    search::prune(board, fit);
    all
}

/// Whether a correction is how stiffly an open-loop drive holds the shaft, and effects are viscous friction: while the drive is on only their
/// sum shows.
fn shows_in_sum(board: &Board, own: &[Effect], effects: &[Effect]) -> bool {
    let viscous = Effect::new(Site::Torque, Carrier::Power(1.0));
    let corrects = own.iter().filter_map(|effect| board.correction(effect));
    let mut paths = corrects.flat_map(|(correction, _)| correction.knob.paths());
    let mut benches = board.benches.iter();
    effects == [viscous]
        && paths.any(|path| path.to_string() == "shaft.stiffness_n_m_s")
        && benches.all(|bench| bench.plant.law.off_s.is_infinite())
}
