//! The index: which edge of the disc a place is, and where the index moved against it.

use super::{CountEvent, CountKind, Edges};

/// One pass of the index, high from one place to another.
#[derive(Clone, Copy, Debug)]
struct Pass {
    time_s: f64,
    ends: [f64; 2],
}

impl Pass {
    fn middle(&self) -> f64 {
        0.5 * (self.ends[0] + self.ends[1])
    }

    /// The sector of a class that lies most within the pass.
    fn sector(&self, class: i64, classes: i64) -> i64 {
        let middle = (self.middle() - 0.5).round() as i64;
        let within = |sector: i64| {
            let ends = [sector as f64, sector as f64 + 1.0];
            self.ends[1].min(ends[1]) - self.ends[0].max(ends[0])
        };
        let near = middle - classes..=middle + classes;
        near.filter(|sector| (sector - class).rem_euclid(classes) == 0)
            .max_by(|a, b| within(*a).total_cmp(&within(*b)))
            .unwrap_or(middle)
    }
}

/// Makes places those of the disc, by the first pass of the index, and books where later ones stand elsewhere. `zs` are the
/// changes of Z; a high Z in the sector of `class` marks line 0.
pub(super) fn anchor(edges: &mut Edges, zs: &[(f64, bool)], class: i64) {
    let passes = passes(edges, zs);
    let Some(first) = passes.first() else {
        return;
    };
    let classes = i64::from(edges.classes);
    let origin = first.sector(class, classes) - class;
    edges.place.iter_mut().for_each(|place| *place -= origin);
    edges.events.iter_mut().for_each(|e| e.place -= origin);
    edges.anchored = true;

    let turn = f64::from(edges.grid_edges);
    let (mut stands, mut after_s) = (first.middle(), first.time_s);
    for pass in &passes[1..] {
        let way = pass.middle() - stands;
        let off = (way - turn * (way / turn).round()).round();
        if off != 0.0 {
            edges.events.push(CountEvent {
                kind: CountKind::IndexSlip,
                time_s: pass.time_s,
                after_s,
                place: pass.middle().round() as i64 - origin,
                channel: quadcal::edge::Levels::Z,
                edges: off as i32,
            });
            stands = pass.middle();
        }
        after_s = pass.time_s;
    }
}

/// Passes with both ends in one direction; their ends are places between edges, by time.
fn passes(edges: &Edges, zs: &[(f64, bool)]) -> Vec<Pass> {
    let mut next = 0;
    let mut risen: Option<(f64, bool)> = None;
    let mut passes = Vec::new();
    for &(time_s, level) in zs {
        while edges.time_s.get(next).is_some_and(|&t| t < time_s) {
            next += 1;
        }
        let at = next.checked_sub(1).and_then(|last| {
            let there = |n: usize| Some((*edges.time_s.get(n)?, *edges.place.get(n)? as f64));
            let ((from_s, from), (until_s, until)) = (there(last)?, there(next)?);
            let part = (time_s - from_s) / (until_s - from_s).max(f64::MIN_POSITIVE);
            Some((from + (until - from) * part, *edges.forward.get(next)?))
        });
        if level {
            risen = at;
        } else if let (Some((start, way)), Some((end, same))) = (risen.take(), at)
            && way == same
        {
            passes.push(Pass {
                time_s,
                ends: [start.min(end), start.max(end)],
            });
        }
    }
    passes
}
