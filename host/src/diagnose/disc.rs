//! What was learned of a disc that the twins do not give, or of another one than they give.

use super::bench::Bench;
use super::diagnosis::{Finding, Parameter};
use super::effect::{Carrier, Site};
use super::lsq;
use super::model::{Board, Fit, Model, Term};
use super::name::NINETY_FIVE;
use super::search;
use super::spread::Spread;
use crate::mechanism::Mechanism;
use crate::report::si;

/// Edges a turn up to which each is said.
const FEW: usize = 16;

/// Errors of the edges that repeat each turn, rad, beside what a model leaves of each angle.
pub fn pattern(board: &Board, rests: &[Vec<f64>]) -> Option<Vec<f64>> {
    let pattern = board.pattern.as_ref()?;
    Some(pattern.closest(&board.benches, &board.with_pattern(rests)))
}

/// Residual angles beside a model and the disc's pattern, rad, of each recording.
pub fn rests(board: &Board, model: &Model) -> Vec<Vec<f64>> {
    let mut rests = board.rest(model);
    if let Some(errors) = pattern(board, &rests) {
        for (bench, rest) in board.benches.iter().zip(&mut rests) {
            bench.less_errors(rest, &errors);
        }
    }
    rests
}

/// By how much each edge of each recording is off by a model and the disc's pattern, rad.
pub fn shifts(board: &Board, model: &Model) -> Vec<Vec<f64>> {
    let errors = pattern(board, &board.rest(model));
    let turned = turned_by(board, model);
    let each = board.benches.iter().map(|bench| {
        let mut off = vec![-turned; bench.record.len()];
        if let Some(errors) = &errors {
            lsq::add(&mut off, 1.0, &bench.record.shown(errors));
        }
        let shifts = |term: &&Term| {
            matches!(
                term.effect.site,
                Site::Disc(_) | Site::Level(_) | Site::Stamp(_)
            )
        };
        for term in model.terms.iter().filter(shifts) {
            for (column, size) in bench.columns(&term.effect).iter().zip(&term.sizes) {
                lsq::add(&mut off, *size, column);
            }
        }
        off
    });
    each.collect()
}

/// What open terms of the disc do to each of its edges, rad: all, or those that are none of classes of edges.
fn open_terms(board: &Board, model: &Model, classes: bool) -> Vec<f64> {
    let Some(record) = board.benches.first().map(|bench| &bench.record) else {
        return Vec::new();
    };
    let open = model.terms.iter().filter(|term| term.nuisance);
    let open = open.filter(|term| term.effect.is_of_disc());
    let open = open.filter(|term| classes || term.effect.carrier != Carrier::Steady);
    let mut errors = vec![0.0; record.edges as usize];
    for term in open {
        for (slot, error) in errors.iter_mut().enumerate() {
            *error += record.error_of(slot, &term.effect, &term.sizes);
        }
    }
    errors
}

/// By how much a disc that the twins do not give is turned by open terms of it, rad: several may add up to an angle of all edges, which no
/// recording shows. An unknown disc counts from where its edges are right in the mean; torques go by that angle.
fn turned_by(board: &Board, model: &Model) -> f64 {
    if board.disc_given {
        return 0.0;
    }
    let errors = open_terms(board, model, false);
    errors.iter().sum::<f64>() / errors.len().max(1) as f64
}

/// How late each stamp of a recording is by a model, s.
pub fn late_s(bench: &Bench, model: &Model) -> Vec<f64> {
    let mut late_s = vec![0.0; bench.record.len()];
    let delays = |term: &&Term| matches!(term.effect.site, Site::Stamp(_));
    for term in model.terms.iter().filter(delays) {
        for (column, size) in bench.columns(&term.effect).iter().zip(&term.sizes) {
            let off = column.iter().zip(&bench.course.speed);
            for (late_s, (off, speed)) in late_s.iter_mut().zip(off) {
                if *speed != 0.0 {
                    *late_s -= size * off / speed;
                }
            }
        }
    }
    late_s
}

/// Errors of the edges that repeat each turn with all else of the disc that is no finding, rad.
pub fn learned(board: &Board, model: &Model) -> Option<Vec<f64>> {
    let mut errors = pattern(board, &board.rest(model))?;
    let turned = turned_by(board, model);
    for (error, open) in errors.iter_mut().zip(open_terms(board, model, true)) {
        *error += open - turned;
    }
    Some(errors)
}

/// How sure the disc's errors are that a fit leaves: variances of a wave of unit size of each order, rad^2.
pub fn variances(board: &Board, fit: &Fit) -> Option<Vec<f64>> {
    let pattern = board.pattern.as_ref()?;
    let mut variances = pattern.variances(&board.benches);
    let columns = fit.of.iter().enumerate();
    for (at, (term, _)) in columns.filter(|(_, (_, number))| *number == 0) {
        let effect = &fit.model.terms[*term].effect;
        if let (true, Carrier::Order(order)) = (effect.is_of_disc(), effect.carrier)
            && let Some(variance) = variances.get_mut(order as usize)
        {
            // Wave and pattern share an order, which the recordings tell as one.
            let both = fit.covariance[(at, at)] + fit.covariance[(at + 1, at + 1)];
            let wave = 0.25 * pattern.edges as f64 * both;
            *variance = (wave - pattern.size2).max(*variance);
        }
    }
    Some(variances)
}

/// How sure the disc's errors are that a fit leaves.
pub fn spread(board: &Board, fit: &Fit) -> Option<Spread> {
    let edges = board.pattern.as_ref()?.edges;
    Some(Spread::of(&variances(board, fit)?, edges))
}

/// Root of the mean square about the mean.
pub fn rms(errors: &[f64]) -> f64 {
    let count = errors.len().max(1) as f64;
    let mean = errors.iter().sum::<f64>() / count;
    let squares = errors.iter().map(|error| (error - mean).powi(2));
    (squares.sum::<f64>() / count).sqrt()
}

/// Another disc than the twins give.
#[derive(Clone, Copy, Debug)]
pub struct Other {
    /// Its evidence.
    pub worth: f64,
    /// By how much the sum of squares falls with it.
    pub fall: f64,
}

/// What another disc than the twins give explains beside a fit; none where it is theirs.
pub fn other(board: &Board, fit: &Fit) -> Option<Other> {
    let own = board.pattern.as_ref();
    let mut own = own
        .filter(|own| board.disc_given && !own.known && own.size2 > 0.0)?
        .clone();
    let mut without = board.clone();
    without.pattern = without.pattern_given();
    let open2 = without.pattern.as_ref().map_or(0.0, |given| given.size2);
    if own.size2 <= open2 {
        return None;
    }
    let plain = without.fit(&fit.model);
    let white = without.with_pattern(&without.rest(&plain.model));
    let mut worth = own.size_up(&board.benches, &white);
    if let Some(given) = &mut without.pattern {
        worth -= given.size_up(&board.benches, &white);
    }
    Some(Other {
        worth: search::evidence(board, worth, 1),
        fall: (plain.rss - fit.rss).max(0.0),
    })
}

/// The finding that the disc is another one than the twins give, and by how much the sum of squares falls with it.
pub fn finding(board: &Board, fit: &Fit, spread: f64) -> Option<(Finding, f64)> {
    let Other { worth, fall } = other(board, fit)?;
    let own = board.pattern.as_ref()?;
    let errors = pattern(board, &board.rest(&fit.model))?;
    let orders = 1..=errors.len() / 2;
    let open =
        orders.clone().map(|order| own.variance(order)).sum::<f64>() / orders.count().max(1) as f64;
    let size = rms(&errors).hypot(open.sqrt());
    let unit =
        |value: f64, error: f64| Parameter::about(value, "rad", NINETY_FIVE * spread * error);
    let mut parameters = std::collections::BTreeMap::new();
    let by_count = open.sqrt() / (errors.len() as f64).sqrt();
    parameters.insert("rms_rad".to_owned(), unit(size, by_count));
    if errors.len() <= FEW {
        for (slot, error) in errors.iter().enumerate() {
            parameters.insert(format!("e_{slot:02}_rad"), unit(*error, open.sqrt()));
        }
    }
    let text = format!(
        "the disc is another one than the twin gives: its edges differ by {} RMS, the same in every turn",
        si(size, "rad")
    );
    let finding = Finding {
        parameters,
        ..Finding::of(Mechanism::LineError, text, worth)
    };
    Some((finding, fall))
}
