//! Whether a table's line pattern is that of the disc recorded.
//!
//! At every edge the mean relative speed as captured holds the line errors of the disc, and what the table takes out of it holds those
//! of the table. Of both the neighbours of the same class are taken off, which leaves neither class means and delays nor the
//! shaft's slow swings; then the one is fitted to the other. The entries are weighed by what is known of them, so the fit gives 1 on
//! their disc and 0 on another, whatever the noise.

use super::Profile;

/// Edges from which on a turn tells discs apart.
const EDGES_LEAST: usize = 64;

/// Standard errors that must lie between a disc and another.
const SURE: f64 = 3.0;

/// How much of a table's pattern a recording shows.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PatternFound {
    /// 1 for the table's own disc, 0 for another.
    pub share: f64,
    /// Standard error of that.
    pub standard_error: f64,
}

impl PatternFound {
    /// Of the mean speeds at every edge of a sensor with so many edge classes; none with few edges, a table without a pattern, or where
    /// chance could make either of the other.
    #[must_use]
    pub fn of(profile: &Profile, classes: usize) -> Option<Self> {
        let before = bare(&profile.mean_before, classes)?;
        let after = bare(&profile.mean_after, classes)?;
        let taken: Vec<f64> = before.iter().zip(&after).map(|(b, a)| b - a).collect();
        let power: f64 = taken.iter().map(|t| t * t).sum();
        if power <= 0.0 {
            return None;
        }
        let share = before.iter().zip(&taken).map(|(b, t)| b * t).sum::<f64>() / power;
        let rest = before
            .iter()
            .zip(&taken)
            .map(|(b, t)| (b - share * t).powi(2));
        // Taking the neighbours off makes noise at one edge reach three, and what is left of it is not independent: a third is.
        #[allow(clippy::cast_precision_loss)]
        let variance = 3.0 * rest.sum::<f64>() / before.len() as f64 / power;
        let standard_error = variance.sqrt();
        (0.5 > SURE * standard_error).then_some(Self {
            share,
            standard_error,
        })
    }

    /// Whether it is another disc.
    #[must_use]
    pub fn other_disc(&self) -> bool {
        self.share < 0.5
    }
}

/// Each value less the mean of its neighbours of the same class, a turn being a ring.
fn bare(values: &[f64], classes: usize) -> Option<Vec<f64>> {
    let edges = values.len();
    if edges < EDGES_LEAST || classes == 0 {
        return None;
    }
    let at = |k: usize| values[k % edges];
    let bare = |k: usize| at(k) - 0.5 * (at(k + classes) + at(k + edges - classes));
    Some((0..edges).map(bare).collect())
}
