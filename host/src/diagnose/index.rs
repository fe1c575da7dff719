//! Where on the disc the index comes, pass by pass, and when it moved.

/// One end of an index pulse.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Pass {
    /// When, s.
    pub time_s: f64,
    /// Where, in edges counted from the start, forward.
    pub at: f64,
    /// Whether it is the pulse's end further along the disc.
    pub upper: bool,
    /// Whether the shaft went forward.
    pub forward: bool,
}

/// The index moved against the disc.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Moved {
    /// Last time it was in its old place, and first time in its new one, s.
    pub between_s: [f64; 2],
    /// How far, edges, forward positive.
    pub edges: i32,
}

/// A new place that has yet to be borne out.
#[derive(Clone, Copy, Debug)]
struct Candidate {
    edges: i64,
    between_s: [f64; 2],
}

/// Share of a small change of place that is followed: delays move edges against the index as the speed changes.
const FOLLOWED: f64 = 0.5;

/// Moves of the index, from where the ends of its pulses were in turns of `edges` edges. A new place counts once it is seen twice: a
/// pulse that changes under the head, or a spurious one, is in no place for long.
#[must_use]
pub fn moves(passes: &[Pass], edges: i64) -> Vec<Moved> {
    let turn = edges as f64;
    let mut found = Vec::new();
    let mut usual: [Option<f64>; 4] = [None; 4];
    let (mut moved, mut last_s) = (0, None);
    let mut candidate: Option<Candidate> = None;
    for pass in passes {
        let usual = &mut usual[2 * usize::from(pass.upper) + usize::from(pass.forward)];
        let at = pass.at - moved as f64;
        let Some(before) = usual else {
            if candidate.is_none() {
                *usual = Some(at);
                last_s = Some(pass.time_s);
            }
            continue;
        };
        let off = at - *before;
        let off = off - (off / turn).round() * turn;
        let steps = off.round() as i64;
        if steps == 0 {
            *usual = Some(at - off + FOLLOWED * off);
            last_s = Some(pass.time_s);
            candidate = None;
            continue;
        }
        match candidate {
            Some(seen) if seen.edges == steps => {
                found.push(Moved {
                    between_s: seen.between_s,
                    edges: i32::try_from(steps).unwrap_or(0),
                });
                moved += steps;
                last_s = Some(pass.time_s);
                candidate = None;
            }
            _ => {
                candidate = Some(Candidate {
                    edges: steps,
                    between_s: [last_s.unwrap_or(pass.time_s), pass.time_s],
                });
            }
        }
    }
    found
}

#[cfg(test)]
mod tests {
    use super::*;

    fn forward(at: &[f64]) -> Vec<Pass> {
        let both = at.iter().enumerate().flat_map(|(n, at)| {
            [(0.5, false), (1.5, true)].map(|(more, upper)| Pass {
                time_s: n as f64 + 0.01 * more,
                at: at + more,
                upper,
                forward: true,
            })
        });
        both.collect()
    }

    #[test]
    fn a_move_lies_between_the_last_pass_in_the_old_place_and_the_first_in_the_new() {
        let passes = forward(&[0.0, 100.1, 200.0, 297.0, 396.9, 497.0]);
        let moved = moves(&passes, 100);
        assert_eq!(moved.len(), 1);
        assert_eq!(moved[0].edges, -3);
        assert!((moved[0].between_s[0] - 2.015).abs() < 1e-9);
        assert!((moved[0].between_s[1] - 3.005).abs() < 1e-9);
    }

    #[test]
    fn a_single_stray_end_and_a_creeping_place_are_no_moves() {
        let mut passes = forward(&[0.0, 100.0, 200.0, 300.0]);
        passes[4].at += 7.0;
        assert!(moves(&passes, 100).is_empty());
        let creeping: Vec<f64> = (0..20).map(|turn| 100.2 * f64::from(turn)).collect();
        assert!(moves(&forward(&creeping), 100).is_empty());
    }

    #[test]
    fn two_moves_add_up_and_one_between_the_last_two_passes_is_seen() {
        let moved = moves(&forward(&[0.0, 102.0, 202.0, 303.0]), 100);
        let edges: Vec<i32> = moved.iter().map(|moved| moved.edges).collect();
        assert_eq!(edges, [2, 1]);
    }
}
