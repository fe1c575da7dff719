//! Learns from any number of recordings of one encoder, one after the other.

use quadcal::estimate::{Anchor, DriveKnowledge, Estimator, Goal, Progress, Totals};
use quadcal::step::Faults;

use super::one_disc::{Likeness, Pattern};
use super::turns::TurnClock;
use super::{
    CalibrateError, CalibrateOptions, Calibration, LearningProgress, LinesFrom, RecordingUse,
};
use crate::buffers::HeapBuffers;
use crate::recording::{ReadError, Row};
use crate::sensor::{PlanError, SensorPlan};
use crate::survey::Survey;

/// Turns of a recording that are learned from at the least, whatever the goal: a speed must be known to be told from another.
const TURNS_MIN: u32 = 3;

/// An estimator that recordings are added to. Rows are taken as they come; nothing keeps a recording.
pub struct Learner {
    plan: SensorPlan,
    clock_hz: u64,
    drive: DriveKnowledge,
    estimator: Estimator<HeapBuffers>,
    progress: LearningProgress,
    goal: Option<Goal>,
    recordings: Vec<RecordingUse>,
    /// What each recording shows of the disc by itself, where it shows enough; none where they are not compared.
    patterns: Option<Vec<Option<Pattern>>>,
}

impl Learner {
    /// A learner of the sensor `plan`, whose recordings count `clock_hz` ticks a second.
    ///
    /// # Errors
    /// [`CalibrateError::Plan`] when the core can't take such an encoder.
    pub fn new(
        plan: SensorPlan,
        clock_hz: u64,
        drive: DriveKnowledge,
    ) -> Result<Self, CalibrateError> {
        Ok(Self {
            plan,
            clock_hz,
            drive,
            estimator: estimator(plan, drive)?,
            progress: LearningProgress::default(),
            goal: None,
            recordings: Vec::new(),
            patterns: None,
        })
    }

    /// The same, which refuses a recording of another disc than those before. Takes as long again, so not for a single recording.
    #[must_use]
    pub fn comparing_discs(self) -> Self {
        Self {
            patterns: Some(Vec::new()),
            ..self
        }
    }

    /// Learns from the `rows` of a recording, as far as the options' `turns`, `until` and `goal` go. It must agree with those before,
    /// see [`agree`](super::agree).
    ///
    /// # Errors
    /// [`CalibrateError::Read`] when the recording can't be read, [`CalibrateError::TooFewTurns`] when none of its turns can be
    /// used, [`CalibrateError::OtherDisc`] where discs are compared.
    pub fn add(
        &mut self,
        survey: Survey,
        rows: impl Iterator<Item = Result<Row, ReadError>>,
        options: &CalibrateOptions,
    ) -> Result<(), CalibrateError> {
        let before = *self.estimator.totals();
        self.goal = options.goal;
        let most = options.turns.unwrap_or(u32::MAX);
        let mut decoder = self.plan.decoder()?;
        let edges = self.estimator.shape().edges();
        let mut clock = TurnClock::new(edges, self.plan.anchor() == Anchor::Index);
        let mut learned_until = 0;
        let mut alone = match &self.patterns {
            Some(_) => Some(estimator(self.plan, self.drive)?),
            None => None,
        };
        for row in rows {
            let row = row?;
            if options.until.is_some_and(|until| row.ticks > until) {
                break;
            }
            let outcome = decoder.push(row);
            clock.push(&outcome);
            if let Some(alone) = &mut alone {
                alone.push(&outcome);
            }
            match self.estimator.push(&outcome) {
                Progress::Running => {}
                Progress::TurnRejected(reason) => clock.reject(reason, &outcome),
                Progress::TurnTaken(turns) => {
                    learned_until = row.ticks;
                    clock.take();
                    let here = turns - before.turns;
                    let outlook = self.estimator.outlook();
                    let enough = self.progress.push(turns, outlook, options.goal);
                    if here >= most || (enough && here >= TURNS_MIN) {
                        break;
                    }
                }
            }
        }
        self.estimator.interrupt();
        let after = self.estimator.totals();
        let [shortest, longest] = clock.range();
        let totals = Totals {
            turns: after.turns - before.turns,
            broken: after.broken - before.broken,
            irregular: after.irregular - before.irregular,
            speed_change: after.speed_change - before.speed_change,
            disagrees: after.disagrees - before.disagrees,
            shortest,
            longest,
        };
        if totals.turns == 0 {
            return Err(CalibrateError::TooFewTurns(totals));
        }
        self.compare(alone)?;
        self.recordings.push(RecordingUse {
            lines_from: LinesFrom::of(&survey, options),
            survey,
            totals,
            rejected: clock.into_rejected(),
            faults: decoder.faults(),
            learned_until,
        });
        Ok(())
    }

    /// Holds a recording that was learned from by itself against those before.
    fn compare(&mut self, alone: Option<Estimator<HeapBuffers>>) -> Result<(), CalibrateError> {
        let Some(patterns) = &mut self.patterns else {
            return Ok(());
        };
        // With a turn or two there is nothing to compare.
        let solved = alone.and_then(|estimator| estimator.solve().ok());
        let pattern = solved.map(|solution| Pattern::of(&solution));
        for (other, before) in patterns.iter().enumerate() {
            let pair = pattern.as_ref().zip(before.as_ref());
            let likeness = pair.and_then(|(this, before)| this.likeness(before));
            if let Some(likeness) = likeness.filter(Likeness::two_discs) {
                return Err(CalibrateError::OtherDisc { other, likeness });
            }
        }
        patterns.push(pattern);
        Ok(())
    }

    /// What each recording gave so far.
    #[must_use]
    pub fn recordings(&self) -> &[RecordingUse] {
        &self.recordings
    }

    /// Leaves orders up to `last` alone, as a speed loop may hide them.
    pub fn leave_alone_up_to(&mut self, last: u16) {
        self.drive.hidden_up_to = last;
    }

    /// Solves for the table.
    ///
    /// # Errors
    /// [`CalibrateError::TooFewTurns`].
    pub fn solve(self) -> Result<Calibration, CalibrateError> {
        let totals = *self.estimator.totals();
        let solution = self
            .estimator
            .with_knowledge(self.drive)
            .solve()
            .map_err(|_| CalibrateError::TooFewTurns(totals))?;
        let faults = self
            .recordings
            .iter()
            .fold(Faults::default(), |sum, used| sum_of(sum, used.faults));
        Ok(Calibration {
            plan: self.plan,
            clock_hz: self.clock_hz,
            drive: self.drive,
            solution,
            loop_error_rad: 0.0,
            loops_undone: false,
            progress: self.progress,
            goal: self.goal,
            totals,
            faults,
            recordings: self.recordings,
        })
    }
}

fn estimator(
    plan: SensorPlan,
    drive: DriveKnowledge,
) -> Result<Estimator<HeapBuffers>, CalibrateError> {
    let shape = plan.shape()?;
    let buffers = HeapBuffers::new(shape.edges() as usize);
    let estimator =
        Estimator::new(shape, plan.anchor(), buffers).map_err(|_| PlanError::Lines(plan.lines))?;
    Ok(estimator.with_knowledge(drive))
}

fn sum_of(one: Faults, other: Faults) -> Faults {
    Faults {
        illegal: one.illegal.saturating_add(other.illegal),
        lost: one.lost.saturating_add(other.lost),
        extra: one.extra.saturating_add(other.extra),
        glitch: one.glitch.saturating_add(other.glitch),
        abrupt_reversal: one.abrupt_reversal.saturating_add(other.abrupt_reversal),
        interval_spike: one.interval_spike.saturating_add(other.interval_spike),
        repeated: one.repeated.saturating_add(other.repeated),
        missed: one.missed.saturating_add(other.missed),
    }
}
