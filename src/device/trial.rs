//! The new table on trial: its corrections, while its entries stay where they were solved for.

use super::proof::Corrected;
use crate::slot::SlotHeader;
use crate::step::Step;
use crate::table::ErrorTable;
use crate::units::{Turn32, TurnDelta32};

/// A table without its entries, and the last angle.
#[derive(Clone, Copy, Debug)]
pub(super) struct Trial {
    table: ErrorTable<'static, i16>,
    last: Turn32,
}

impl Trial {
    /// Of a solved table, for edges stamped by a clock of `clock_hz`. None where the table is not whole.
    pub fn new(header: &SlotHeader, entries: &[i16], clock_hz: u64) -> Option<Self> {
        let table = ErrorTable::new(header.shape, header.class_offsets, entries, header.shift);
        let delays = header.delays.at_clock(clock_hz)?;
        Some(Self {
            table: table.ok()?.with_delays(delays).without_entries(),
            last: Turn32(0),
        })
    }

    /// What the table with these entries makes of an edge. On the edge path while proving.
    pub fn push(&mut self, step: &Step, entries: &[i16]) -> Corrected {
        let offset = self.table.error(step.edge, false);
        let angle = self.table.angle_with(step.edge, offset, entries);
        let moved = angle.minus(core::mem::replace(&mut self.last, angle));
        let late = self
            .table
            .delay_after(step.edge, step.direction, step.flags)
            .late;
        Corrected {
            moved: TurnDelta32(moved.0),
            late,
        }
    }
}
