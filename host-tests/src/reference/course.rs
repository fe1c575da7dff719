//! The speed's own course: what a motion through more crossings of edge 0 has that constant acceleration has not.

/// A turn of a recording, where its neighbours tell more of it.
#[derive(Debug, Clone, Copy)]
pub(super) struct Place {
    /// Its number among the recording's turns.
    pub turn: usize,
    /// Whether it was folded along the turn before it.
    pub along: bool,
}

/// Numbers of the crossings that tell how the turn `row[at]` went; none where they are no more than it was folded along. In a row each
/// turn follows on the one before.
fn nodes(row: &[Place], at: usize) -> Option<std::ops::RangeInclusive<usize>> {
    let turn = row[at].turn;
    if !row[at].along {
        return None;
    }
    let known_before = at > 0 && row[at - 1].along;
    match (known_before, at + 1 < row.len()) {
        (true, true) => Some(turn - 2..=turn + 2),
        (false, true) => Some(turn - 1..=turn + 2),
        (true, false) => Some(turn - 2..=turn + 1),
        (false, false) => None,
    }
}

/// What the shaft is further than `folded` has it at the times `tau` of the turn `row[at]`, turns. `ends` are the times of edge 0 in the
/// recording.
pub(super) fn off(row: &[Place], at: usize, ends: &[f64], tau: &[f64], folded: &[f64]) -> Vec<f64> {
    let Some(nodes) = nodes(row, at) else {
        return vec![0.0; tau.len()];
    };
    let turn = row[at].turn;
    let time = |n: usize| (ends[n] - ends[turn]) / (ends[turn + 1] - ends[turn]);
    let angle = |tau: f64| -> f64 {
        let terms = nodes.clone().map(|n| {
            let others = nodes.clone().filter(|&other| other != n);
            let factors = others.map(|other| (tau - time(other)) / (time(n) - time(other)));
            (n as f64 - turn as f64) * factors.product::<f64>()
        });
        terms.sum()
    };
    tau.iter()
        .zip(folded)
        .map(|(&tau, folded)| angle(tau) - folded)
        .collect()
}
