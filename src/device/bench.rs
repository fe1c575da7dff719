//! What a device needs of the firmware's part that sees the edges.

use crate::estimate::{Advice, DriveKnowledge, Goal};
use crate::recalibrate::{Action, Figures, SolveInSlices};
use crate::slot::SlotHeader;
use crate::step::Outcome;
use crate::store::Found;
use crate::wire::Live;

/// How learning goes.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Learning {
    /// Turns taken since the calibration began.
    pub turns: u32,
    /// Turns that could not be used.
    pub rejected: u32,
}

/// The part that sees the edges, as the main loop sees it, which takes them from the capture interrupt by a queue. [`super::Workbench`] is
/// one; none of these calls takes longer than a slice of solving, but for getting ready to learn, which clears
/// the memory, and adopting a table, whose check sum is taken.
pub trait Bench: SolveInSlices {
    /// Does what the machine says; all but writing, which is the store's.
    fn perform(&mut self, action: &Action);

    /// The shaft now.
    fn live(&mut self) -> Live;

    /// Mean speed over a part of a turn, either way, thousandths of a revolution a minute; 0 where it stands still.
    fn speed(&mut self) -> u32;

    /// How learning goes; asked at every poll.
    fn learning(&mut self) -> Learning;

    /// Works out, slice by slice, whether more turns would help; asked at every poll while it learns. What it comes to is said once, some
    /// polls after a turn was taken.
    fn advice(&mut self) -> Option<Advice>;

    /// What fresh turns say so far.
    fn figures(&mut self) -> Figures;

    /// The table that was solved for: what it says of itself, and its entries.
    fn candidate(&self) -> Option<(SlotHeader, &[i16])>;

    /// Room for the entries of a table that is handed over, one an edge; what was learned is given up for it. None while it is needed.
    /// What was put there stays until [`Action::Prepare`] or [`Action::Release`].
    fn room(&mut self) -> Option<&mut [i16]>;

    /// Holds the table in [`Self::room`], which says this of itself, against the one in use on the turns that come: [`Self::figures`] has
    /// what they say. The next action ends it.
    fn compare(&mut self, header: &SlotHeader);

    /// Corrects with a table of the store from now on, or with none. False where it can't be used, and then there is none.
    fn adopt(&mut self, found: Option<&Found>) -> bool;

    /// Temperature of the encoder, 1/16 degree Celsius.
    fn temperature_q4(&mut self) -> Option<i16> {
        None
    }
}

/// What learns: an estimator with its memory, through all that becomes of it.
pub trait Learner: SolveInSlices {
    /// Forgets everything and gets ready to learn.
    fn prepare(&mut self, knowledge: DriveKnowledge, goal: Goal);

    /// Takes what a decoder made of a sample. On the edge path.
    fn push(&mut self, outcome: &Outcome);

    /// Edges will be missing: what comes next may have another speed or direction. Constant work.
    fn interrupt(&mut self);

    /// As [`Bench::learning`].
    fn learning(&mut self) -> Learning;

    /// As [`Bench::advice`].
    fn advice(&mut self) -> Option<Advice>;

    /// What the table says of itself, once it is solved for.
    fn header(&self) -> Option<SlotHeader>;

    /// Its entries then.
    fn entries(&self) -> &[i16];

    /// As [`Bench::room`]. On the edge path too, while what was put there is compared: then it returns at once.
    fn room(&mut self) -> Option<&mut [i16]>;

    /// Gives up what was learned.
    fn release(&mut self);
}
