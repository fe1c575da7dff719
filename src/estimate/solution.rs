//! What a calibration found.

use super::EdgeBuffers;
use super::delays::SolvedDelays;
use super::order::{LOCKED_MAX, LockedOrder, ORDERS_MAX, TORQUES_MAX, TorqueOrder};
use crate::shape::{CLASSES_MAX, EncoderShape};
use crate::units::{TickDelta8, TurnDelta32};

/// Why nothing could be solved.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum SolveError {
    /// Fewer than two turns were taken, so nothing says how well turns agree.
    TooFewTurns(u32),
}

/// Delays found: class c is captured `of_class[c]` late, zero mean over the classes.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct ClassDelays {
    /// Of each class; those beyond C are zero.
    pub of_class: [TickDelta8; CLASSES_MAX],
    /// Standard error of one of them, 2^-8 tick.
    pub standard_error: u32,
}

/// A solved error table with what is known about it. The error of edge k is
/// `class_offset(k mod C) + (entries()[k] << shift())`: shaft angle = grid angle - error.
pub struct Solution<B> {
    pub(super) findings: Findings,
    pub(super) buffers: B,
}

/// All of it but the buffers, which hold the table's entries.
pub struct Findings {
    pub(super) shape: EncoderShape,
    pub(super) turns: u32,
    pub(super) class_offsets: [TurnDelta32; CLASSES_MAX],
    pub(super) class_error: u32,
    pub(super) shift: u32,
    pub(super) residual: u32,
    pub(super) table_rms: u32,
    pub(super) uncorrected: u32,
    pub(super) single: [u16; ORDERS_MAX],
    pub(super) single_count: usize,
    pub(super) common: u16,
    pub(super) locked: heapless::Vec<LockedOrder, LOCKED_MAX>,
    pub(super) torques: heapless::Vec<TorqueOrder, TORQUES_MAX>,
    pub(super) reference: u64,
    pub(super) delays: Option<SolvedDelays>,
}

impl<B: EdgeBuffers> Solution<B> {
    /// The encoder's shape.
    #[must_use]
    pub fn shape(&self) -> EncoderShape {
        self.findings.shape
    }

    /// Turns that the estimate rests on.
    #[must_use]
    pub fn turns(&self) -> u32 {
        self.findings.turns
    }

    /// Mean error of an edge class; the means of all classes sum to zero.
    #[must_use]
    pub fn class_offset(&self, class: usize) -> TurnDelta32 {
        self.findings
            .class_offsets
            .get(class)
            .copied()
            .unwrap_or_default()
    }

    /// Mean errors of all classes; those beyond C are zero.
    #[must_use]
    pub fn class_offsets(&self) -> &[TurnDelta32; CLASSES_MAX] {
        &self.findings.class_offsets
    }

    /// Standard error of a class offset, 2^-32 turn.
    #[must_use]
    pub fn class_standard_error(&self) -> u32 {
        self.findings.class_error
    }

    /// Line position error of every edge, in `1 << shift()` of 2^-32 turn, zero mean in every class.
    #[must_use]
    pub fn entries(&self) -> &[i16] {
        let cells = self.buffers.cells();
        cells
            .get(..self.findings.shape.edges() as usize)
            .unwrap_or(cells)
    }

    /// Scale of [`Solution::entries`].
    #[must_use]
    pub fn shift(&self) -> u32 {
        self.findings.shift
    }

    /// Standard error of one edge's line position error: the error RMS to expect after correction, orders left alone
    /// included at the size of their neighbours, 2^-32 turn.
    #[must_use]
    pub fn standard_error(&self) -> u32 {
        self.findings.residual
    }

    /// Error RMS to expect without the table, class offsets included, 2^-32 turn. Less than [`Solution::table_rms`] where noise is much of
    /// the table.
    #[must_use]
    pub fn uncorrected_rms(&self) -> u32 {
        self.findings.uncorrected
    }

    /// RMS of the error that the table holds, class offsets included, 2^-32 turn.
    #[must_use]
    pub fn table_rms(&self) -> u32 {
        self.findings.table_rms
    }

    /// Weight of an order in 0..=1 (Q15): how far its estimate is believed.
    #[must_use]
    pub fn order_weight(&self, order: usize) -> u16 {
        if order == 0 || order > self.findings.single_count {
            self.findings.common
        } else {
            self.findings.single[order - 1]
        }
    }

    /// Orders that one speed can't decide, left alone.
    #[must_use]
    pub fn locked_orders(&self) -> &[LockedOrder] {
        &self.findings.locked
    }

    /// Torque locked to the shaft, told from geometry by turns of different speed; the strongest orders.
    #[must_use]
    pub fn torque_orders(&self) -> &[TorqueOrder] {
        &self.findings.torques
    }

    /// Duration of the first turn taken, ticks: the speed that [`TorqueOrder::amplitude`] holds for.
    #[must_use]
    pub fn reference_duration(&self) -> u64 {
        self.findings.reference
    }

    /// How late edges of each class are captured, forward; none where the speeds were too alike to tell, or no delay stands
    /// out.
    #[must_use]
    pub fn class_delays(&self) -> Option<ClassDelays> {
        let delays = self.findings.delays.as_ref()?;
        Some(ClassDelays {
            of_class: delays.ticks_q8.map(TickDelta8),
            standard_error: delays.error_q8,
        })
    }

    /// Gives the buffers back.
    pub fn into_buffers(self) -> B {
        self.buffers
    }
}
