//! What pushed a shaft, and how far it has gone under it.

use super::command::{Command, Shares};
use super::crossing::Crossing;
use super::model::LoopModel;
use super::torque::{TorqueMotion, TorqueRecord};
use crate::twin::Gains;

/// What pushed the shaft.
#[derive(Clone, Debug, PartialEq)]
pub enum Push {
    /// A speed loop, whose torque follows from the edges.
    Loop(LoopModel),
    /// A torque that was recorded.
    Torque(TorqueRecord),
}

/// A shaft's displacement as it goes on.
#[derive(Clone, Debug)]
pub(super) enum Pushed {
    Loop(Box<Command>),
    Torque(TorqueMotion),
}

impl Pushed {
    /// Goes on to a tick.
    pub fn reach(&mut self, ticks: u64) -> Shares {
        match self {
            Self::Loop(command) => command.reach(ticks),
            Self::Torque(torque) => torque.reach(ticks),
        }
    }

    /// Takes an edge at the tick just reached.
    pub fn edge(&mut self, crossing: &Crossing) {
        if let Self::Loop(command) = self {
            command.edge(crossing.ticks, crossing.direction, crossing.steps);
        }
    }
}

impl Push {
    /// The displacement from tick `from` on.
    pub(super) fn start(&self, clock_hz: u64, step_rad: f64, from: u64) -> Pushed {
        match self {
            Self::Loop(model) => {
                Pushed::Loop(Box::new(Command::new(model, clock_hz, step_rad, from)))
            }
            Self::Torque(record) => Pushed::Torque(TorqueMotion::new(record, clock_hz, from)),
        }
    }

    /// Viscous friction over inertia, 1/s.
    #[must_use]
    pub fn viscous(&self) -> f64 {
        match self {
            Self::Loop(model) => model.viscous,
            Self::Torque(record) => record.viscous(),
        }
    }

    /// Gains by which the shares count.
    #[must_use]
    pub fn gains(&self) -> Gains {
        match self {
            Self::Loop(model) => model.gains,
            Self::Torque(_) => Gains { kp: 1.0, ki: 0.0 },
        }
    }
}
