//! Where a search stands.

use super::hunt::Hunt;
use super::odds::Doubt;
use super::verdict::Place;
use super::watch::Watch;

/// Where the search stands.
#[derive(Clone, Copy, Debug)]
pub(super) enum Stage {
    /// Adding up the table's energy, up to `line`.
    Weigh { line: u32, sum: u64 },
    /// The table's pattern is weaker than its error.
    Weak,
    /// Waiting for a whole window of edges.
    Gather,
    /// Looking for the window in the table.
    Hunt(Hunt),
    /// With a place that the decoder was not told yet.
    Watch(Watch, Option<Place>),
    /// The table is another disc's.
    Refused(Doubt),
}
