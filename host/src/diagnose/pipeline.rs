//! The pipeline: recordings and twins in, an answer out.

use super::alike::swapped;
use super::bench::Bench;
use super::cells::SPEEDS;
use super::diagnosis::{Answer, Map};
use super::edges::{Undecided, Unused, turned};
use super::filter::Noise;
use super::findings::answer;
use super::model::Board;
use super::noise::UNSEEN;
use super::record::Record;
use super::rig::{DiagnoseError, Recorded};
use super::spread::Spread;
use super::{align, jury, map, phases, scan, search, speed_loop, task};
use crate::sim;

/// Edges that a recording needs.
pub const EDGES_LEAST: usize = 200;
/// Turns that it needs.
const TURNS_LEAST: f64 = 3.0;

/// Finds what the twins of one rig lack. Edges of a shaft that turned round, which one channel does not show, are put the way that it went.
///
/// # Errors
/// [`DiagnoseError`] where there is nothing to compare.
pub fn diagnose(
    rig: &mut [Recorded],
    progress: &mut dyn FnMut(f64, &'static str),
) -> Result<Answer, DiagnoseError> {
    progress(0.05, "Comparing");
    rig.iter_mut().try_for_each(turn_round)?;
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
    for bench in &mut benches {
        phases::settle(bench)?;
    }
    let first = some(&benches, stages(&benches)[0])?;
    speed_loop::find(&mut benches, first);
    let mut stages = stages(&benches).into_iter();
    let some_of = |benches: &[Bench], few: Option<i64>| -> Vec<Record> {
        let each = benches.iter().map(|bench| &bench.record);
        each.map(|record| few.map_or_else(|| record.clone(), |few| record.of_some(few)))
            .collect()
    };
    let mut given = some(&benches, stages.next().flatten())?;
    let mut board = Board::new(given.clone());
    progress(0.15, "Searching");
    let mut found = search::search(&mut board);
    progress(0.6, "Weighing look-alikes");
    let mut alike = swapped(&mut board, &found.bank, &mut found.fit);
    progress(0.7, "Mapping");
    let mut map = mapped(&board, &found);
    for few in stages {
        progress(0.75, "Going on with more edges");
        let some = some_of(&benches, few);
        let sized = some.iter().map(Record::len).sum::<usize>() > SEARCHED;
        if sized {
            found.hold(&mut board);
        }
        let Some(more) = board.along(some, &found.fit.model) else {
            break;
        };
        board = more;
        if sized {
            found.settle(&mut board);
        } else if found.go_on(&mut board) {
            alike = swapped(&mut board, &found.bank, &mut found.fit);
            map = mapped(&board, &found);
        }
        if few.is_none() {
            given = std::mem::take(&mut benches);
        }
    }
    let given = Board::of(given);
    progress(0.9, "Judging");
    if jury::bear_out(&mut board, &mut found.fit, &mut found.worth) {
        map = mapped(&board, &found);
    }
    if search::needless(&given, &mut board, &mut found) {
        map = mapped(&board, &found);
    }
    if board.edges() <= SEARCHED {
        found.hold(&mut board);
    }
    if let Some(by) = align::index_moved(&board, &found.fit)
        && rig.iter_mut().all(|one| one.edges.move_index(by))
    {
        return diagnose(rig, progress);
    }
    let rig = &*rig;
    let search::Found {
        fit, worth, noise, ..
    } = &found;
    let mut terms = fit.model.terms.iter();
    let drags = terms.any(|term| !term.nuisance && term.effect.is_friction());
    let mut answer = answer(rig, &given, &board, fit, &alike, worth, *noise);
    answer.not_identifiable = found.not_identifiable;
    if !board.disc_given && board.speed_spread() < SPEEDS {
        let open = "torques at whole orders: at one speed the disc's own errors look the same";
        answer.not_identifiable.push(open.to_owned());
    }
    if !search::past_learned(&board).is_empty() {
        let open = "what of edge classes goes with the speed: the twin's disc was learned at one speed, with their delays in it (errors.learned_r_min)";
        answer.not_identifiable.push(open.to_owned());
    }
    if board.undriven && !board.is_looped() && !drags {
        let open = "friction, loads and inertia, as the twin gives no drive, and what they change looks like what a drive does";
        answer.not_identifiable.push(open.to_owned());
    }
    answer.map = map;
    Ok(answer)
}

/// The map of what is left beside what is no finding, and beside all that was found.
fn mapped(board: &Board, found: &search::Found) -> Map {
    let before = board.fit(&found.fit.model.nuisances());
    map::map(
        &search::candidates(board, &found.bank, &before),
        &search::candidates(board, &found.bank, &found.fit),
    )
}

/// Puts edges the way that the shaft went.
fn turn_round(one: &mut Recorded) -> Result<(), DiagnoseError> {
    one.edges = turned(std::mem::take(&mut one.edges), &one.twin).map_err(|why| {
        DiagnoseError::Reversal {
            file: one.file.clone(),
            why,
        }
    })?;
    Ok(())
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
    let mut record = Record::of(edges, &one.twin);
    if let Some(some) = some_of(record.edges, record.len(), SIZED) {
        record = record.of_some(some);
    }
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
        unseen: UNSEEN,
        ..Noise::default()
    };
    let mut bench = Bench::new(record, &one.twin, &errors, &noise);
    if let Some(record) = whole_turns(&bench) {
        bench = Bench::new(record, &one.twin, &errors, &noise);
    }
    bench.spread = Spread {
        edge_rad: sim::disc_spread_rad(&one.twin)?,
        waves_rad: one.twin.errors.wave_standard_errors_rad.clone(),
    };
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

/// Edges of all recordings that a search begins with, and edges of the disc that it begins with at the least.
const MANY: usize = 18_000;
const FEW: i64 = scan::FEW - 1;
/// Edges that a search ends with: about so many at the most, if the recordings have more.
pub const SEARCHED: usize = 72_000;
/// Edges that bear on the sizes of what it found.
const SIZED: usize = 360_000;

/// Edges of the disc that are looked at, one stage after the other; none for all of them. What the twin says of a recording may go by every
/// edge.
fn stages(benches: &[Bench]) -> Vec<Option<i64>> {
    let by_edge = |bench: &Bench| {
        let twin = &bench.twin;
        twin.speed_loop().is_some() || twin.capture_latency.is_some() || task::shows(bench)
    };
    if benches.iter().any(by_edge) {
        return vec![None];
    }
    let edges: usize = benches.iter().map(|bench| bench.record.len()).sum();
    let all = benches.iter().map(|bench| bench.record.edges).min();
    let some = [MANY, SEARCHED].map(|most| some_of(all.unwrap_or(0), edges, most));
    let mut stages: Vec<_> = some.into_iter().flatten().map(Some).collect();
    stages.push(None);
    stages
}

/// The same with so many edges of the disc.
fn some(benches: &[Bench], few: Option<i64>) -> Result<Vec<Bench>, DiagnoseError> {
    let each = benches.iter().map(|bench| match few {
        Some(few) => Ok(bench.along(bench.record.of_some(few))?),
        None => Ok(bench.clone()),
    });
    each.collect()
}

/// Edges of a disc that make about so many of a recording's, where leaving out the others is worth it.
pub fn some_of(all: i64, edges: usize, most: usize) -> Option<i64> {
    let some = (all as f64 * (most as f64 / 1.5) / edges as f64) as i64;
    let some = some.max(FEW);
    (3 * some < 2 * all).then_some(some)
}
