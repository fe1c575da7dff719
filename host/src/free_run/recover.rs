//! From a recording and what is known of its drive to a free run.

use std::f64::consts::TAU;

use quadcal::estimate::Anchor;

use super::command::Shares;
use super::crossing::{Crossing, first_turns};
use super::error::FreeRunError;
use super::fit::{self, Fit};
use super::motion::Response;
use super::phase;
use super::push::{Push, Pushed};
use super::repeat::{Repeated, TurnSums};
use super::rows::FreeRows;
use super::trend::{Trend, TrendFit};
use crate::recording::{Header, ReadError, Row};
use crate::sensor::{Decoder, SensorPlan};
use crate::survey::Survey;
use crate::twin::Gains;

/// Ticks of a free run in one of the recording: rounding is far below what the capture itself rounds.
pub const FINER: u64 = 16;
/// Turns that the gains are measured on, at most.
const FIT_TURNS: usize = 16;
/// Steps of Newton's method from the mean speed to the time of an angle.
const INVERSIONS: usize = 4;

/// How well the drive is known.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Knowledge {
    /// Relative standard deviation of each gain (with a recorded torque, of the inertia). 0 takes them as they are; anything above lets
    /// the recording correct them.
    pub gains_within: f64,
    /// Whether the loop's sample times are known; if not, they are looked for.
    pub phase: bool,
}

/// How the times of a recording become those of a free run.
#[derive(Clone)]
pub struct FreeRun {
    pub(super) push: Push,
    given: Gains,
    pub(super) gains: Gains,
    /// Of the loop's displacement by share, and of the angle that the grid shows.
    trend: Trend<4>,
    /// How the free run goes on: the motion of constant acceleration nearest to that of the recording.
    pace: Trend<1>,
    /// As it is before the first row.
    pub(super) decoder: Decoder,
    pub(super) anchor: Anchor,
    pub(super) clock_hz: u64,
    pub(super) step_rad: f64,
    pub(super) from: u64,
    /// Mean speed, rad/s, negative in reverse.
    pub(super) speed: f64,
    fit: Option<Fit>,
    /// Relative standard deviation of the gains as they were given.
    gains_within: f64,
    pub(super) repeated: Repeated,
}

impl FreeRun {
    /// Works out the loop's doing in a recording that `open` opens, twice.
    ///
    /// # Errors
    /// [`FreeRunError`] when the recording can't be read or is too short.
    pub fn of<I, E>(
        mut open: impl FnMut() -> Result<I, E>,
        header: &Header,
        plan: SensorPlan,
        push: Push,
        knowledge: Knowledge,
    ) -> Result<Self, E>
    where
        I: Iterator<Item = Result<Row, ReadError>>,
        E: From<FreeRunError>,
    {
        let edges = plan.shape().map_err(FreeRunError::from)?.edges();
        let clock_hz = header.clock_hz;
        let (mut push, mut gains) = (push.clone(), push.gains());
        let unsure_phase = !knowledge.phase && matches!(push, Push::Loop(_));
        let mut found = None;
        if unsure_phase || knowledge.gains_within > 0.0 {
            let crossings = first_turns(open()?, plan, FIT_TURNS * edges as usize)?;
            let data = fit::Data {
                crossings: &crossings,
                clock_hz,
                edges,
            };
            if let (true, Push::Loop(model)) = (unsure_phase, &mut push) {
                model.phase_s = phase::find(data, model, knowledge.gains_within.max(0.01))
                    .ok_or(FreeRunError::TooShort)?;
            }
            if knowledge.gains_within > 0.0 {
                let fit = fit::fit(data, &push, knowledge.gains_within);
                let fit = fit.ok_or(FreeRunError::TooShort)?;
                if fit.is_plausible(gains, knowledge.gains_within) {
                    gains = fit.gains;
                    found = Some(fit);
                }
            }
        }
        let run = Self {
            given: push.gains(),
            push,
            gains,
            trend: Trend::none(),
            pace: Trend::none(),
            decoder: plan.decoder().map_err(FreeRunError::from)?,
            anchor: plan.anchor(),
            clock_hz,
            step_rad: TAU / f64::from(edges),
            from: 0,
            speed: 0.0,
            fit: found,
            gains_within: knowledge.gains_within,
            repeated: Repeated::default(),
        };
        Ok(run.with_trend(open()?, edges)?)
    }

    /// Takes speed and trend from the whole recording.
    #[allow(clippy::cast_precision_loss)]
    fn with_trend(
        mut self,
        rows: impl Iterator<Item = Result<Row, ReadError>>,
        edges: u32,
    ) -> Result<Self, FreeRunError> {
        if let Push::Loop(model) = &mut self.push {
            // Only a loop at its limit makes a difference of it; its gains are best those found.
            model.gains = self.gains;
        }
        let mut decoder = self.decoder.clone();
        let mut fit = TrendFit::new(self.push.viscous());
        let mut pace = TrendFit::new(0.0);
        let mut turns = TurnSums::new(edges);
        let mut pushed: Option<Pushed> = None;
        let mut mark = None;
        let (mut last, mut steps) = (0, 0_i64);
        for row in rows {
            let row = row?;
            let pushed = pushed.get_or_insert_with(|| {
                self.from = row.ticks;
                self.push.start(self.clock_hz, self.step_rad, row.ticks)
            });
            let Some(crossing) = Crossing::of(&decoder.push(row), self.anchor) else {
                continue;
            };
            let made = pushed.reach(crossing.ticks);
            pushed.edge(&crossing);
            steps += crossing.way();
            last = crossing.ticks;
            let shown = steps as f64 * self.step_rad;
            let time = self.seconds(last);
            // Always at one edge of the disc: the encoder's errors are the same there.
            if crossing.sure && crossing.edge == *mark.get_or_insert(crossing.edge) {
                fit.add(time, &[made[0], made[1], made[2], shown]);
                pace.add(time, &[shown]);
            }
            let free = Response::after(time, self.push.viscous());
            turns.push(&crossing, [made[0], made[1], free.to_speed, free.to_push]);
        }
        self.speed = steps as f64 * self.step_rad / self.seconds(last);
        if !self.speed.is_normal() {
            return Err(FreeRunError::NoRun);
        }
        self.trend = fit.trend();
        self.pace = pace.trend();
        self.repeated = turns.repeated(&self.trend);
        Ok(self)
    }

    #[allow(clippy::cast_precision_loss)]
    pub(super) fn seconds(&self, ticks: u64) -> f64 {
        ticks.saturating_sub(self.from) as f64 / self.clock_hz as f64
    }

    /// How much later the free run is where the shaft was at a tick, s.
    ///
    /// What a free shaft could have done is taken out of the loop's displacement. The same of the angle that the grid shows is put in
    /// its place, so that displacement and smooth motion are the whole motion. A start that had yet to settle, which is in both,
    /// then leaves nothing: the free run has come as far when its pace says so.
    pub(super) fn later(&self, ticks: u64, made: &Shares) -> f64 {
        let time = self.seconds(ticks);
        let [kp, ki, neither, shown] = self.trend.at(time);
        let gone = self.gains.kp * (made[0] - kp)
            + self.gains.ki * (made[1] - ki)
            + (made[2] - neither)
            + shown;
        let mut later = 0.0;
        for _ in 0..INVERSIONS {
            let [pace] = self.pace.speed_at(time + later);
            // A shaft that nearly stands comes to no angle at any sure time.
            let pace = if pace / self.speed < 0.1 {
                self.speed
            } else {
                pace
            };
            later += (gone - self.pace.at(time + later)[0]) / pace;
        }
        later
    }

    /// The gains used, over inertia; with a recorded torque, `kp` is what its accelerations were multiplied by.
    #[must_use]
    pub fn gains(&self) -> Gains {
        self.gains
    }

    /// The gains as they were given.
    #[must_use]
    pub fn given(&self) -> Gains {
        self.given
    }

    /// The gains as measured, with their standard errors; none where they were taken as given, because that was asked for or what was
    /// measured is far from it.
    #[must_use]
    pub fn fit(&self) -> Option<&Fit> {
        self.fit.as_ref()
    }

    /// Standard error, RMS over a turn, rad, of what wrong gains leave in the encoder's errors turn after turn: from how well they were
    /// measured, or else from how well they were said to be known.
    #[must_use]
    pub fn repeating_error_rad(&self) -> f64 {
        if let Some(fit) = &self.fit {
            return self.repeated.rms(fit.standard_error, fit.correlation);
        }
        let error = Gains {
            kp: self.gains_within * self.given.kp,
            ki: self.gains_within * self.given.ki,
        };
        self.repeated.rms(error, 0.0)
    }

    /// What pushed, with the sample times as given or found.
    #[must_use]
    pub fn push(&self) -> &Push {
        &self.push
    }

    /// Mean speed, rad/s, negative in reverse.
    #[must_use]
    pub fn speed_rad_s(&self) -> f64 {
        self.speed
    }

    /// The free run's header: a finer clock.
    #[must_use]
    pub fn header(&self, header: &Header) -> Header {
        Header {
            clock_hz: header.clock_hz.saturating_mul(FINER),
            ..header.clone()
        }
    }

    /// The survey of the free run from that of the recording.
    #[must_use]
    pub fn survey(&self, mut survey: Survey) -> Survey {
        survey.header = self.header(&survey.header);
        survey.first = steady(survey.first, self.clock_hz);
        survey.last = steady(survey.last, self.clock_hz);
        survey
    }

    /// About which tick of the recording a tick of the free run stands for.
    #[must_use]
    pub fn recorded(&self, free_ticks: u64) -> u64 {
        (free_ticks / FINER).saturating_sub(self.clock_hz)
    }

    /// The rows of the free run from those of the recording, in `FINER` ticks, a second later.
    pub fn rows<I>(&self, rows: I) -> FreeRows<I>
    where
        I: Iterator<Item = Result<Row, ReadError>>,
    {
        FreeRows::new(self, rows)
    }
}

/// The tick of a free run for one of the recording that the loop did not displace: a second later, which is more than a loop holds a
/// shaft back.
pub(super) fn steady(ticks: u64, clock_hz: u64) -> u64 {
    ticks.saturating_add(clock_hz).saturating_mul(FINER)
}
