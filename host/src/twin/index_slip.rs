//! The index moves against the disc.

use serde::{Deserialize, Serialize};

use super::whole::whole;

/// `[[index_slip]]`: from a time on the index is some steps of the grid further along the disc; slips add up. If it slips while it is
/// under the head, its level changes at that time.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct IndexSlip {
    /// When it slips, 0 or later.
    pub at_s: f64,
    /// Steps of the grid, forward if positive; not 0, less than a turn.
    #[serde(deserialize_with = "whole")]
    pub edges: i32,
}
