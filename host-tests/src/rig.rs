//! A simulated rig with everything a drive can do to an encoder's edges: wander, ripple, reversals, lost edges, glitches and
//! late interrupt handlers; as an event file, with the truth beside it.

use std::collections::HashMap;
use std::f64::consts::TAU;

use quadcal::edge::Sample;
use quadcal::replay::corrected::CorrectedFile;
use quadcal::replay::{Header, TimerWidth, Wiring};
use quadcal::slot::{Slot, SlotError};
use quadcal::step::Flags;
use quadcal::units::{RAD_PER_TURN32, Ticks};
use quadcal_host::sim::{Event, Simulation};
use quadcal_host::twin::{
    Drive, Duration, Encoder, Faults, Noise, Per, Position, Step, Twin, TwinError,
};

use crate::accuracy::{distance, rms};
use crate::events::{Events, Latency, events};

/// The timer clock of an STM32F405.
const CLOCK_HZ: u32 = 84_000_000;

/// A rig to replay.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Rig {
    /// Lines of the disc; its errors are those of the paper, in parts of a step.
    pub lines: u32,
    /// Width of the capture timer.
    pub timer: TimerWidth,
    /// Turns to learn.
    pub turns: u32,
    /// Seed of everything random.
    pub seed: u64,
}

/// What a rig gave: the events, and the truth apart from them.
pub struct Run {
    /// The event file's header.
    pub header: Header,
    /// The events as the handlers saw them.
    pub events: Events,
    /// True error of every edge, rad.
    pub errors: Vec<f64>,
    /// True shaft angle at every time stamp, rad.
    angles: HashMap<Ticks, f64>,
}

impl Rig {
    /// Speed, r/min: with 32 bits slow enough for the timer to wrap once.
    fn r_min(self) -> f64 {
        match self.timer {
            TimerWidth::Bits16 => 60.0,
            TimerWidth::Bits32 => 15.0,
        }
    }

    /// Forward, back and forward again; one edge lost in the third turn and one after the second reversal. Learning ends
    /// going back, with turns to spare for those that faults and the reversal spoil.
    fn twin(self) -> Twin {
        let edges = u64::from(4 * self.lines);
        // Errors in parts of a step stay those of the paper's disc.
        let scale = 2500.0 / f64::from(self.lines);
        let r_min = self.r_min();
        let turn_s = 60.0 / r_min;
        let step = |turns: f64, sign: f64| Step {
            t_s: turns * turn_s,
            r_min: sign * r_min,
        };
        let last = f64::from(self.turns) + 12.6;
        let mut twin = Twin::paper();
        twin.seed = self.seed;
        twin.duration = Duration::Turns(last + 4.0);
        twin.encoder = Encoder::Quadrature {
            lines: self.lines,
            index: true,
        };
        twin.errors.position = Some(Position::Uniform {
            amplitude_rad: 6.2832e-5 * scale,
            per: Per::Edge,
        });
        twin.errors.width_a_rad *= scale;
        twin.errors.width_b_rad *= scale;
        twin.errors.quadrature_rad *= scale;
        twin.drive = Drive::Steps(vec![step(0.0, 1.0), step(4.3, -1.0), step(last, 1.0)]);
        twin.noise = Some(Noise::SpeedWander {
            rms_fraction: 1e-3,
            correlation_rad: Some(0.5),
            hold_s: None,
        });
        twin.faults = Faults {
            lost_edges: vec![2 * edges + edges / 9, u64::from(self.turns + 14) * edges],
            // Four a run or so.
            glitch_probability: 4.0 / ((last + 4.0) * edges as f64),
            glitch_width_s: 0.02 * turn_s / edges as f64,
            ..Faults::default()
        };
        twin
    }

    /// Runs the rig.
    ///
    /// # Errors
    /// As the simulator.
    pub fn run(self) -> Result<Run, TwinError> {
        let simulation = Simulation::new(&self.twin())?;
        let errors = simulation.true_errors();
        let rows: Vec<Event> = simulation.collect();
        let samples: Vec<Sample> = rows.iter().map(|event| event.row).collect();
        let header = Header {
            timer: self.timer,
            wiring: Wiring::Quadrature,
            lines: self.lines,
            clock_hz: CLOCK_HZ,
            turns: self.turns,
        };
        let angles = rows
            .iter()
            .filter(|event| event.truth.edge.is_some())
            .map(|event| (event.row.ticks, event.truth.angle_rad))
            .collect();
        Ok(Run {
            header,
            events: events(
                &samples,
                self.timer,
                Latency::longest(self.timer, self.seed),
            ),
            errors,
            angles,
        })
    }
}

impl Run {
    /// The event file's bytes.
    #[must_use]
    pub fn file(&self) -> Vec<u8> {
        self.events.file(&self.header)
    }

    /// RMS error of the encoder over that after correction with a table.
    ///
    /// # Errors
    /// The slot's.
    pub fn table_gain(&self, slot: &[u8]) -> Result<f64, SlotError> {
        let table = Slot::parse(slot)?.angles().map_err(SlotError::Table)?;
        let error = |edge: u32| f64::from(table.error(edge, true).0) * RAD_PER_TURN32;
        let learned: Vec<f64> = (0..4 * self.header.lines).map(error).collect();
        let zero = vec![0.0; learned.len()];
        Ok(distance(&zero, &self.errors) / distance(&learned, &self.errors))
    }

    /// The same from the corrected angles of all edges whose count is not in doubt, and their number.
    #[must_use]
    pub fn angle_gain(&self, corrected: &CorrectedFile<'_>) -> (f64, usize) {
        let sure = corrected
            .edges()
            .filter(|edge| !edge.flags.contains(Flags::TURN_SUSPECT));
        let mut off: Vec<f64> = sure
            .filter_map(|edge| {
                let truth = self.angles.get(&(edge.ticks + self.events.base))?;
                let off = (f64::from(edge.angle.0) * RAD_PER_TURN32 - truth).rem_euclid(TAU);
                Some(if off > TAU / 2.0 { off - TAU } else { off })
            })
            .collect();
        let count = off.len();
        let mean = off.iter().sum::<f64>() / count as f64;
        off.iter_mut().for_each(|off| *off -= mean);
        let zero = vec![0.0; self.errors.len()];
        (distance(&zero, &self.errors) / rms(&off), count)
    }
}
