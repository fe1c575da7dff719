//! Luck or bias: how far the true values are from their intervals when one case is recorded again and again with other noise.

use std::collections::BTreeMap;
use std::fmt::Write as _;

use super::cases::first_name;
use super::score::Score;

/// Halves of a 95 % interval to standard deviations.
const DEVIATIONS: f64 = 1.96;

/// A line for each case and parameter: mean and standard deviation of the true value's distance from the interval's middle, in standard
/// deviations as the interval claims them (0 and 1 where it is right), and how often the interval held it.
#[must_use]
pub fn luck(scores: &[Score]) -> String {
    let mut groups: BTreeMap<(&str, String), Vec<f64>> = BTreeMap::new();
    for score in scores {
        for compared in &score.parameters {
            let name = format!("{} {}", compared.mechanism.id(), compared.name);
            if let Some(off) = compared.off {
                let group = groups.entry((first_name(&score.case), name)).or_default();
                group.push(DEVIATIONS * off);
            }
        }
    }
    let mut text = format!(
        "{:<10} {:<40}{:>8}{:>8}{:>12}\n",
        "case", "parameter", "mean", "SD", "held"
    );
    for ((case, name), off) in groups {
        let count = off.len() as f64;
        let mean = off.iter().sum::<f64>() / count;
        let squares: f64 = off.iter().map(|off| (off - mean).powi(2)).sum();
        let deviation = (squares / (count - 1.0).max(1.0)).sqrt();
        let held = off.iter().filter(|off| off.abs() <= DEVIATIONS).count();
        let held = format!("{held} of {}", off.len());
        let _ = writeln!(
            text,
            "{case:<10} {name:<40}{mean:>8.2}{deviation:>8.2}{held:>12}"
        );
    }
    text
}
