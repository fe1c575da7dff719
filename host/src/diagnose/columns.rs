//! Columns of effects, kept while they may be asked for again: raw along one recording, as fits in another noise ask for the same ones, and
//! white of all recordings, as fits in the same noise do.

use std::collections::VecDeque;
use std::sync::atomic::{AtomicU64, Ordering};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};

use super::effect::Effect;

/// Numbers of all columns that are kept of one recording, or of all recordings in one noise: 40 MB.
const KEPT: usize = 5_000_000;

/// What an effect does to each edge for unit of each size.
pub type Columns = Arc<Vec<Vec<f64>>>;

/// The last columns, the newest first.
#[derive(Clone, Debug, Default)]
struct Last {
    columns: VecDeque<(Effect, Columns)>,
    /// What they hold of.
    mark: Vec<u64>,
}

impl Last {
    fn get(&mut self, effect: &Effect) -> Option<Columns> {
        let found = self.columns.iter().position(|(own, _)| own == effect);
        let entry = found.and_then(|at| self.columns.remove(at))?;
        let columns = Arc::clone(&entry.1);
        self.columns.push_front(entry);
        Some(columns)
    }

    fn put(&mut self, effect: &Effect, columns: &Columns) {
        let numbers: usize = columns.iter().map(Vec::len).sum();
        self.columns.push_front((*effect, Arc::clone(columns)));
        self.columns.truncate((KEPT / numbers.max(1)).max(1));
    }
}

fn locked(last: &Mutex<Last>) -> MutexGuard<'_, Last> {
    last.lock().unwrap_or_else(PoisonError::into_inner)
}

/// Columns along one course. Clones share them.
#[derive(Clone, Debug)]
pub struct Kept {
    last: Arc<White>,
    /// Which course it is: no other one has the same.
    pub course: u64,
}

impl Default for Kept {
    fn default() -> Self {
        static COURSES: AtomicU64 = AtomicU64::new(0);
        Self {
            last: Arc::default(),
            course: COURSES.fetch_add(1, Ordering::Relaxed),
        }
    }
}

impl Kept {
    /// Those of an effect, worked out where they are not kept.
    pub fn of(&self, effect: &Effect, work_out: impl Fn() -> Vec<Vec<f64>>) -> Columns {
        let each = |open: &[Effect]| open.iter().map(|_| work_out()).collect();
        self.last.of(Vec::new(), &[*effect], each).swap_remove(0)
    }
}

/// White columns of all recordings in one noise. Clones keep their own, as they may go on in another one.
#[derive(Debug, Default)]
pub struct White(Mutex<Last>);

impl Clone for White {
    fn clone(&self) -> Self {
        Self(Mutex::new(locked(&self.0).clone()))
    }
}

impl White {
    /// Those of some effects; those that are not kept are worked out together. `mark` says of which courses in which noise: others are
    /// forgotten.
    pub fn of(
        &self,
        mark: Vec<u64>,
        effects: &[Effect],
        work_out: impl FnOnce(&[Effect]) -> Vec<Vec<Vec<f64>>>,
    ) -> Vec<Columns> {
        let mut found: Vec<Option<Columns>> = {
            let mut last = locked(&self.0);
            if last.mark != mark {
                last.columns.clear();
                last.mark = mark;
            }
            effects.iter().map(|effect| last.get(effect)).collect()
        };
        let open = found.iter().zip(effects);
        let open = open.filter(|(found, _)| found.is_none());
        let open: Vec<Effect> = open.map(|(_, effect)| *effect).collect();
        let mut made = work_out(&open).into_iter().map(Arc::new);
        let mut last = locked(&self.0);
        for (found, effect) in found.iter_mut().zip(effects) {
            if found.is_none() {
                *found = made.next();
                found.iter().for_each(|columns| last.put(effect, columns));
            }
        }
        found.into_iter().flatten().collect()
    }
}
