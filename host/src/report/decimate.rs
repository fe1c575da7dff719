//! Thinning of long series, in pixels, so that nothing a person would see is lost.

use std::collections::{BTreeMap, HashSet};

/// A position in pixels, y downwards; `None` is a gap.
pub(super) type Place = Option<(f64, f64)>;

/// Splits at the gaps and keeps, of each run of samples in one pixel column, the lowest and the highest in their order.
/// A series whose x wanders to and fro is thinned by its own order instead, so that the result stays within about eight
/// points a column.
pub(super) fn polyline(
    points: impl Iterator<Item = Place> + Clone,
    columns: f64,
) -> Vec<Vec<(f64, f64)>> {
    let most = (columns.max(1.0) * 8.0) as usize;
    let by_column = runs(points.clone(), |_, x| x.floor() as i64);
    if by_column.iter().map(Vec::len).sum::<usize>() <= most {
        return by_column;
    }
    let each = (points.clone().count() * 2).div_ceil(most).max(1);
    runs(points, |i, _| (i / each) as i64)
}

fn runs(
    points: impl Iterator<Item = Place>,
    key: impl Fn(usize, f64) -> i64,
) -> Vec<Vec<(f64, f64)>> {
    let mut out = Vec::new();
    let mut line = Vec::new();
    let mut run: Option<Run> = None;
    for (i, place) in points.enumerate() {
        let Some((x, y)) = place else {
            run.take().into_iter().for_each(|r| r.put(&mut line));
            if !line.is_empty() {
                out.push(std::mem::take(&mut line));
            }
            continue;
        };
        let column = key(i, x);
        match &mut run {
            Some(r) if r.column == column => r.take(i, (x, y)),
            _ => {
                run.take().into_iter().for_each(|r| r.put(&mut line));
                run = Some(Run::new(column, i, (x, y)));
            }
        }
    }
    run.into_iter().for_each(|r| r.put(&mut line));
    if !line.is_empty() {
        out.push(line);
    }
    out
}

/// Consecutive samples that share a column.
struct Run {
    column: i64,
    low: (usize, (f64, f64)),
    high: (usize, (f64, f64)),
}

impl Run {
    fn new(column: i64, i: usize, at: (f64, f64)) -> Self {
        Self {
            column,
            low: (i, at),
            high: (i, at),
        }
    }

    fn take(&mut self, i: usize, at: (f64, f64)) {
        if at.1 < self.low.1.1 {
            self.low = (i, at);
        }
        if at.1 > self.high.1.1 {
            self.high = (i, at);
        }
    }

    fn put(self, line: &mut Vec<(f64, f64)>) {
        let (first, second) = if self.low.0 <= self.high.0 {
            (self.low, self.high)
        } else {
            (self.high, self.low)
        };
        line.push(first.1);
        if second.0 != first.0 {
            line.push(second.1);
        }
    }
}

/// One point for each cell of `grid` pixels that holds any.
pub(super) fn scatter(points: impl Iterator<Item = Place>, grid: f64) -> Vec<(f64, f64)> {
    let mut seen = HashSet::new();
    points
        .flatten()
        .filter(|(x, y)| seen.insert(((x / grid).floor() as i64, (y / grid).floor() as i64)))
        .collect()
}

/// The highest point (smallest y) of each pixel column, from left to right.
pub(super) fn crest(points: impl Iterator<Item = Place>) -> Vec<(f64, f64)> {
    let mut columns: BTreeMap<i64, (f64, f64)> = BTreeMap::new();
    for (x, y) in points.flatten() {
        let top = columns.entry(x.floor() as i64).or_insert((x, y));
        if y < top.1 {
            *top = (x, y);
        }
    }
    columns.into_values().collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn one_spike_in_a_million_samples_survives() {
        let n = 1_000_000;
        let at = |i: usize| {
            let y = match i {
                123_456 => 900.0,
                777_777 => -900.0,
                _ => (i as f64 * 0.01).sin(),
            };
            Some((i as f64 / n as f64 * 800.0, y))
        };
        let out = polyline((0..n).map(at), 800.0);
        assert_eq!(out.len(), 1);
        assert!(out[0].len() <= 1600, "{}", out[0].len());
        assert!(out[0].contains(&at(123_456).unwrap()));
        assert!(out[0].contains(&at(777_777).unwrap()));
        assert!(out[0].windows(2).all(|w| w[0].0 <= w[1].0));
    }

    #[test]
    fn a_short_series_passes_unchanged_and_gaps_split_it() {
        let points = [
            None,
            Some((0.0, 1.0)),
            Some((9.0, 2.0)),
            None,
            None,
            Some((20.0, 3.0)),
        ];
        let out = polyline(points.into_iter(), 100.0);
        assert_eq!(out, [vec![(0.0, 1.0), (9.0, 2.0)], vec![(20.0, 3.0)]]);
        assert!(polyline(std::iter::empty(), 100.0).is_empty());
    }

    #[test]
    fn a_series_that_runs_to_and_fro_stays_bounded_and_keeps_its_extremes() {
        let at = |i: usize| {
            let y = if i == 54_321 { 77.0 } else { (i % 7) as f64 };
            Some(((i * 37 % 100) as f64, y))
        };
        let out = polyline((0..100_000).map(at), 100.0);
        assert!(out[0].len() <= 800, "{}", out[0].len());
        assert!(out[0].contains(&at(54_321).unwrap()));
    }

    #[test]
    fn scatter_and_crest_keep_what_shows() {
        let dots = scatter((0..10_000).map(|i| Some(((i % 10) as f64, 0.0))), 1.0);
        assert_eq!(dots.len(), 10);
        let top = crest([Some((1.2, 5.0)), Some((1.4, 2.0)), None, Some((3.0, 9.0))].into_iter());
        assert_eq!(top, [(1.4, 2.0), (3.0, 9.0)]);
    }
}
