//! How wide the states of a sensor's code are.

use super::code::Code;
use super::mender::Edge;

/// How wide each state of a code is, relative to their mean: the middle of what the rows show.
pub(super) fn widths(code: Code, edges: &[Edge]) -> Vec<f64> {
    const EACH_MOST: usize = 5000;
    let states = usize::try_from(code.states()).unwrap_or(1);
    let mut seen: Vec<Vec<f64>> = vec![Vec::new(); states];
    let apart = (edges.len() / EACH_MOST / states).max(1) * states + 1;
    for from in (0..edges.len().saturating_sub(states)).step_by(apart) {
        let round = &edges[from..=from + states];
        let whole = round[states].ticks - round[0].ticks;
        let state = round
            .get(states / 2)
            .and_then(|edge| code.state(edge.levels));
        if let Some(state) = state
            && whole > 0
        {
            let own = round[states / 2 + 1].ticks - round[states / 2].ticks;
            let share = own as f64 * states as f64 / whole as f64;
            seen[usize::try_from(state).unwrap_or(0)].push(share);
        }
    }
    let middle = |mut shares: Vec<f64>| {
        shares.sort_by(f64::total_cmp);
        shares
            .get(shares.len() / 2)
            .copied()
            .unwrap_or(1.0)
            .clamp(0.2, 3.0)
    };
    seen.into_iter().map(middle).collect()
}
