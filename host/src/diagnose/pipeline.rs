//! The pipeline: recordings and twins in, an answer out.

use super::alike::swapped;
use super::bench::Bench;
use super::diagnosis::Answer;
use super::edges::{Undecided, Unused, turned};
use super::filter::Noise;
use super::findings::answer;
use super::model::Board;
use super::record::Record;
use super::rig::{DiagnoseError, Recorded};
use super::{align, map, search};
use crate::sim;

/// Edges that a recording needs.
pub const EDGES_LEAST: usize = 200;
/// Turns that it needs.
const TURNS_LEAST: f64 = 3.0;

/// Finds what the twins of one rig lack.
///
/// # Errors
/// [`DiagnoseError`] where there is nothing to compare.
pub fn diagnose(
    rig: &[Recorded],
    progress: &mut dyn FnMut(f64, &'static str),
) -> Result<Answer, DiagnoseError> {
    progress(0.05, "Comparing");
    let rig: Result<Vec<Recorded>, DiagnoseError> = rig.iter().map(way).collect();
    let rig = &rig?;
    let mut benches = Vec::new();
    for (place, one) in rig.iter().enumerate() {
        let mut bench = likelier(one)?;
        bench.place = place as u8;
        benches.push(bench);
    }
    let turns = align::turns(&benches);
    for (bench, by) in benches.iter_mut().zip(turns) {
        if by != 0 {
            bench.turn(by)?;
        }
    }
    let mut board = Board::new(benches);
    let given = board.clone();
    progress(0.15, "Searching");
    let search::Found {
        mut fit,
        bank,
        not_identifiable,
        worth,
        noise,
    } = search::search(&mut board);
    progress(0.6, "Weighing look-alikes");
    let alike = swapped(&mut board, &bank, &mut fit);
    progress(0.85, "Judging");
    let mut answer = answer(rig, &given, &board, &fit, &alike, &worth, noise);
    answer.not_identifiable = not_identifiable;
    let nuisances = fit.model.nuisances();
    let before = board.fit(&nuisances);
    answer.map = map::map(
        &search::candidates(&board, &bank, &before),
        &search::candidates(&board, &bank, &fit),
    );
    Ok(answer)
}

/// A recording with the way that its shaft went.
fn way(one: &Recorded) -> Result<Recorded, DiagnoseError> {
    let undecided = |why| DiagnoseError::Reversal {
        file: one.file.clone(),
        why,
    };
    let edges = turned(one.edges.clone(), &one.twin).map_err(undecided)?;
    Ok(Recorded {
        edges,
        ..one.clone()
    })
}

/// A recording beside its twin, the way that its disc says where nothing else does.
fn likelier(one: &Recorded) -> Result<Bench, DiagnoseError> {
    let forward = bench(one)?;
    if !one.edges.either_way() || forward.disc.iter().all(|error| *error == 0.0) {
        return Ok(forward);
    }
    let other = Recorded {
        edges: one.edges.mirrored(),
        ..one.clone()
    };
    let backward = bench(&other)?;
    let lost = |bench: &Bench| -> Result<f64, DiagnoseError> {
        let mut bench = bench.clone();
        let by = align::turns(std::slice::from_ref(&bench))[0];
        bench.turn(by)?;
        let board = Board::new(vec![bench]);
        Ok(board.lost(&board.fit(&search::nuisances(&board))))
    };
    Ok(if lost(&backward)? < lost(&forward)? {
        backward
    } else {
        forward
    })
}

/// A recording beside its twin.
fn bench(one: &Recorded) -> Result<Bench, DiagnoseError> {
    let edges = &one.edges;
    let record = Record::of(edges, &one.twin);
    let turns = record.turns();
    if record.len() < EDGES_LEAST || turns < TURNS_LEAST {
        if edges
            .unused
            .iter()
            .any(|stretch| stretch.why == Unused::EitherWay)
        {
            return Err(DiagnoseError::Reversal {
                file: one.file.clone(),
                why: Undecided::Stops,
            });
        }
        return Err(DiagnoseError::TooShort {
            file: one.file.clone(),
            edges: record.len(),
            turns,
            least: EDGES_LEAST,
        });
    }
    let errors = sim::true_errors(&one.twin)?;
    let noise = Noise {
        torque: 1.0,
        stamp_s: record.tick_s,
        drift: 0.0,
        fade: 0.0,
        angle_rad: 0.0,
    };
    let mut bench = Bench::new(record, &one.twin, &errors, &noise);
    if let Some(record) = whole_turns(&bench) {
        bench = Bench::new(record, &one.twin, &errors, &noise);
    }
    bench.spread_rad = sim::disc_spread_rad(&one.twin)?;
    Ok(bench)
}

/// A recording of one channel whose count is whole turns off after a reversal, which its edges alone do not show: the twin's course does.
fn whole_turns(bench: &Bench) -> Option<Record> {
    const NEAR: usize = 6;
    if bench.record.classes > 2 {
        return None;
    }
    let mut record = bench.record.clone();
    let mut turned = false;
    for at in 1..record.len() {
        if record.way[at] == record.way[at - 1] {
            continue;
        }
        let middle = |range: std::ops::Range<usize>| {
            let mut some: Vec<f64> = bench.residual[range].to_vec();
            some.sort_by(f64::total_cmp);
            some.get(some.len() / 2).copied()
        };
        let (Some(before), Some(after)) = (
            middle(at.saturating_sub(NEAR)..at),
            middle(at..(at + NEAR).min(record.len())),
        ) else {
            continue;
        };
        let turns = ((after - before) / std::f64::consts::TAU).round() as i64;
        if turns != 0 {
            let by = turns * record.edges;
            record.place[at..].iter_mut().for_each(|place| *place -= by);
            turned = true;
        }
    }
    turned.then_some(record)
}
