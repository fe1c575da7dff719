//! Recordings cut to where mended twins go as well: with more friction a twin's shaft comes to rest sooner, and what is too slow to be
//! compared begins earlier.

use super::board::Board;
use super::search::Searched;

/// Part of a recording's edges that have to be left.
const LEFT: f64 = 0.5;

/// How many first edges of each recording mended twins have too; none where they have others, or few.
#[must_use]
pub fn common(given: &Board, mended: &Board) -> Option<Vec<usize>> {
    let pairs = given.benches.iter().zip(&mended.benches);
    let each = pairs.map(|(given, mended)| {
        let turn = given.seen.edges;
        let (given, mended) = (&given.seen.places, &mended.seen.places);
        // A speed that drifts may put the start into another turn.
        let apart = mended.first()? - given.first()?;
        let pairs = given.iter().zip(mended);
        let both = pairs
            .take_while(|(given, mended)| *mended - *given == apart)
            .count();
        (apart % turn == 0 && both as f64 > LEFT * given.len() as f64).then_some(both)
    });
    each.collect()
}

/// Whether any recording has more edges.
#[must_use]
pub fn longer(board: &Board, edges: &[usize]) -> bool {
    let mut each = board.benches.iter().zip(edges);
    each.any(|(bench, edges)| bench.seen.len() > *edges)
}

/// Cuts recordings.
pub fn cut(board: &mut Board, edges: &[usize]) {
    for (bench, edges) in board.benches.iter_mut().zip(edges) {
        if bench.seen.len() > *edges {
            bench.shorten(*edges);
        }
    }
    board.forget();
}

/// Fits what was found in recordings that were cut.
pub fn fit_again(board: &Board, searched: &mut Searched) -> Option<()> {
    let mut columns = board.nuisances();
    searched.nuisances = columns.len();
    for found in &mut searched.found {
        found.columns = found.hypothesis.columns(board);
        columns.extend(found.columns.iter().cloned());
    }
    searched.model = board.fit(columns)?;
    Some(())
}
