//! Columns of effects along one recording, kept while they may be asked for again: fits in another noise ask for the same ones.

use std::collections::VecDeque;
use std::sync::{Arc, Mutex, PoisonError};

use super::effect::Effect;

/// Numbers of all columns that are kept, of one recording: 64 MB.
const KEPT: usize = 8_000_000;

/// What an effect does to each edge, rad, for unit of each size.
pub type Columns = Arc<Vec<Vec<f64>>>;

/// The last columns, the newest first. Clones share them.
#[derive(Clone, Debug, Default)]
pub struct Kept(Arc<Mutex<VecDeque<(Effect, Columns)>>>);

impl Kept {
    /// Those of an effect, worked out where they are not kept.
    pub fn of(&self, effect: &Effect, work_out: impl FnOnce() -> Vec<Vec<f64>>) -> Columns {
        let kept = || self.0.lock().unwrap_or_else(PoisonError::into_inner);
        {
            let mut kept = kept();
            let found = kept.iter().position(|(own, _)| own == effect);
            if let Some(entry) = found.and_then(|at| kept.remove(at)) {
                let columns = Arc::clone(&entry.1);
                kept.push_front(entry);
                return columns;
            }
        }
        let columns: Columns = Arc::new(work_out());
        let numbers: usize = columns.iter().map(Vec::len).sum();
        let mut kept = kept();
        kept.push_front((*effect, Arc::clone(&columns)));
        kept.truncate((KEPT / numbers.max(1)).max(1));
        columns
    }
}
