//! Phases that are each recording's own: what swings at an order that is not whole or at a frequency was anywhere in its cycle when the
//! recording began. Beside the twin without it, its size in quadratures says where.

use super::bench::Bench;
use super::declared;
use super::effect::Effect;
use super::lsq::{self, add};
use super::model::Board;
use super::numbers::{self, Knob};
use super::search;
use crate::sim;
use crate::twin::{Errors, Twin, TwinError};

/// Rounds in which the drive's hold and the noise are found beside what swings.
const HELD: usize = 3;

/// Gives a recording's twin the phases that it shows, where the twin leaves them to each recording.
///
/// # Errors
/// [`TwinError`] for a disc that can't be.
pub fn settle(bench: &mut Bench) -> Result<(), TwinError> {
    let waves = numbers::free_waves(&bench.twin);
    if waves.is_empty() {
        return Ok(());
    }
    let none: Vec<(&Knob, &[f64])> = waves.iter().map(|wave| (wave, &[0.0; 2][..])).collect();
    let Some(silent) = numbers::changed(&bench.twin, &none) else {
        return Ok(());
    };
    let effects = { declared::effects(&bench.twin).into_iter() }
        .zip(declared::effects(&silent))
        .filter(|((_, sizes), (_, none))| sizes != none)
        .map(|((effect, _), _)| effect);
    let effects: Vec<Effect> = effects.collect();
    let disc = sim::true_errors(&silent)?;
    // The disc may be another one than the twin's by now.
    let free = Twin {
        errors: Errors::default(),
        local_defect: Vec::new(),
        ..silent.clone()
    };
    let beside = [(silent, &disc[..]), (free, &[])].map(|(silent, disc)| {
        let mut board = Board::new(vec![bench.anew(&silent, disc, &bench.noise())]);
        let nuisances = search::nuisances(&board);
        // How stiffly an unknown drive holds the shaft turns phases, and what is not in the twin passes for it.
        let model = nuisances.with(&effects, 0);
        for _ in 0..HELD {
            let fit = board.fit_in_noise(&model);
            if !board.hold(&fit.model) {
                break;
            }
        }
        board.go_by(&board.fit(&nuisances).model);
        let fit = board.fit(&nuisances);
        (board.lost(&board.fit(&model)), board, fit)
    });
    let likelier = beside.into_iter().min_by(|a, b| a.0.total_cmp(&b.0));
    let twin = likelier.and_then(|(_, board, fit)| {
        let tree = numbers::tree(&bench.twin)?;
        let plain = &board.benches[0];
        let basis = fit.basis();
        let mut columns = Vec::new();
        for wave in &waves {
            let size = wave.path().number(&tree)?;
            for values in [[size, 0.0], [0.0, size]] {
                let twin = numbers::changed(&plain.twin, &[(wave, &values)])?;
                let mut column = plain.own.clone();
                add(&mut column, -1.0, &plain.beside(&twin)?);
                columns.push(basis.beside(&board.white(&[column])));
            }
        }
        let parts = lsq::solve(&columns, &fit.left).sizes;
        let mut shown = Vec::new();
        for (wave, [cos, sin]) in waves.iter().zip(parts.as_chunks::<2>().0) {
            let by = wave.path().number(&tree)? / cos.hypot(*sin).max(f64::MIN_POSITIVE);
            shown.push((wave, [by * cos, by * sin]));
        }
        let each = shown.iter().map(|(wave, values)| (*wave, &values[..]));
        numbers::changed(&bench.twin, &each.collect::<Vec<_>>())
    });
    if let Some(twin) = twin {
        *bench = bench.anew(&twin, &sim::true_errors(&twin)?, &bench.noise());
    }
    Ok(())
}
