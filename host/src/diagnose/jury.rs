//! Whether findings stay worth their numbers in noise as rigs have it: with a torque that wanders, levels that change and innovations that
//! are far out now and then. What such noise explains as well is not said.

use rayon::prelude::*;

use super::agreement;
use super::filter::Ring;
use super::judge;
use super::model::{Board, Fit, Model, Wander};
use super::noise::Tails;
use super::scan::{SURE, evidence};

/// Numbers of such noise: density and corner of a wander, levels and tails.
const NUMBERS: f64 = 4.0;

/// What was judged.
#[derive(Clone, Debug, Default)]
pub struct Judged {
    /// Evidence of each group beside the noise that explains most without it.
    pub worth: Vec<(usize, f64)>,
    /// Evidence of another noise than the one before.
    pub noise: f64,
    /// Whether the search may find something else now: some were not worth it, or the noise is another one.
    pub changed: bool,
}

/// Takes off a fit what noise explains as well, one after the other or all at once, and goes by the noise that explains most then.
pub fn judge(board: &mut Board, fit: &mut Fit, at_once: bool) -> Judged {
    let mut judged = Judged::default();
    let quiet = agreement::is_white(board, fit) && !agreement::heavy_tails(fit);
    if quiet && fit.model.groups().is_empty() {
        return judged;
    }
    loop {
        let plain = board.lost(fit);
        // What rings beside all findings: one of them may be a part of that, but that is none of theirs.
        let any = likeliest(board, &fit.model, board.may_ring(fit));
        let with = any.2.min(plain);
        let gain = plain - any.2 - NUMBERS * (board.edges() as f64).ln();
        judged.noise += gain.max(0.0);
        let groups = fit.model.groups().into_par_iter().map(|group| {
            let without = fit.model.without(group);
            // Noise fitted without it explains no less than the same noise.
            let most = any.0.lost(&any.0.fit(&without)) - with;
            if most < SURE || !board.is_near(&fit.model, group) {
                return (group, most.min(0.0));
            }
            (group, likeliest(&any.0, &without, None).2 - with)
        });
        judged.worth = groups.collect();
        judged.worth.sort_by(|a, b| a.1.total_cmp(&b.1));
        let weak = judged.worth.iter().filter(|one| one.1 < SURE);
        let weak: Vec<_> = weak.take(if at_once { usize::MAX } else { 1 }).collect();
        if weak.is_empty() {
            if gain > SURE {
                judged.changed |= board.free != any.0.free;
                (*board, *fit, _) = any;
            }
            return judged;
        }
        judged.changed = true;
        let weak = weak.into_iter();
        let rest = weak.fold(fit.model.clone(), |model, one| model.without(one.0));
        (*board, *fit, _) = likeliest(&any.0, &rest, None);
    }
}

/// Takes off a fit what turns that it was not fitted on do not bear out, one after the other, and weighs the others by those turns as well.
/// Whether there was any.
pub fn bear_out(board: &mut Board, fit: &mut Fit, worth: &mut [(usize, f64)]) -> bool {
    let mut any = false;
    loop {
        let groups = fit.model.groups().into_iter();
        let elsewhere = groups.filter_map(|group| {
            let foretold = judge::foretold(board, fit, group)?;
            let numbers = fit.model.numbers(group);
            Some((group, evidence(board, foretold.fall, numbers)))
        });
        let elsewhere: Vec<_> = elsewhere.collect();
        let weakest = elsewhere.iter().min_by(|a, b| a.1.total_cmp(&b.1));
        let Some((group, _)) = weakest.filter(|one| one.1 < SURE) else {
            for (group, worth) in worth {
                let own = elsewhere.iter().find(|(of, _)| of == group);
                *worth = own.map_or(*worth, |(_, own)| worth.min(*own));
            }
            return any;
        };
        any = true;
        let rest = fit.model.without(*group);
        (*board, *fit, _) = board.declaring(&rest).at_its_noise(&rest);
    }
}

/// A model in the noise that makes it most likely.
fn likeliest(board: &Board, model: &Model, ring: Option<Ring>) -> (Board, Fit, f64) {
    let board = board.declaring(model);
    let tails = [Tails::Normal, Tails::Student];
    let quick = tails.map(|tails| (tails, Wander::Quick));
    let lasting = tails.map(|tails| (tails, Wander::Lasting));
    // One that wanders already goes on from there.
    let lasts = board.undriven && board.noise.fade <= 0.0;
    let rings = ring.map(|ring| tails.map(|tails| (tails, Wander::Ringing(ring))));
    let each = quick.into_iter().chain(lasting);
    let each = each.filter(|(_, wander)| lasts || *wander == Wander::Quick);
    let each: Vec<_> = each.chain(rings.into_iter().flatten()).collect();
    let each = each.into_par_iter();
    let each = each.map(|(tails, wander)| board.in_any_noise(tails, wander).at_its_noise(model));
    let mut each: Vec<_> = each.collect();
    each.sort_by(|a, b| a.2.total_cmp(&b.2));
    each.swap_remove(0)
}
