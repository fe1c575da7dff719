//! What the levels of a sensor say of its position, whatever the sensor.

use quadcal::decoder::class_of;
use quadcal::edge::Levels;
use quadcal::hall::state_of;

use crate::sensor::{SensorKind, SensorPlan};

/// A sensor whose levels go round through states, one an edge.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Code {
    /// A and B: four states a line.
    Quadrature,
    /// Three Hall sensors: six states a pole pair.
    Hall,
    /// One channel: high and low.
    OneChannel,
}

impl Code {
    /// That of a sensor; none where the levels carry nothing or teeth are missing.
    #[must_use]
    pub const fn of(plan: SensorPlan) -> Option<Self> {
        match plan.kind {
            SensorKind::Quadrature { .. } => Some(Self::Quadrature),
            SensorKind::Hall => Some(Self::Hall),
            SensorKind::Wheel {
                both_edges: true,
                missing: 0,
            } => Some(Self::OneChannel),
            SensorKind::Wheel { .. } => None,
        }
    }

    /// States in a round.
    #[must_use]
    pub const fn states(self) -> i64 {
        match self {
            Self::Quadrature => 4,
            Self::Hall => 6,
            Self::OneChannel => 2,
        }
    }

    /// Bits of the channels that count.
    #[must_use]
    pub const fn mask(self) -> u8 {
        match self {
            Self::Quadrature => Levels::A | Levels::B,
            Self::Hall => Levels::A | Levels::B | Levels::C,
            Self::OneChannel => Levels::A,
        }
    }

    /// State that levels show, counted forward; none where no position shows them.
    #[must_use]
    pub fn state(self, levels: u8) -> Option<i64> {
        match self {
            Self::Quadrature => Some(class_of(Levels(levels)).into()),
            Self::Hall => state_of(Levels(levels)).map(i64::from),
            Self::OneChannel => Some(i64::from(levels & Levels::A == 0)),
        }
    }

    /// Levels of a state.
    #[must_use]
    pub fn levels(self, state: i64) -> u8 {
        let state = state.rem_euclid(self.states());
        let shows = |levels: &u8| self.state(*levels) == Some(state);
        (0..=self.mask()).find(shows).unwrap_or(0)
    }

    /// The channel that changes from one state to the next in a direction.
    #[must_use]
    pub fn channel(self, state: i64, way: i64) -> usize {
        let changed = self.levels(state) ^ self.levels(state + way);
        changed.trailing_zeros() as usize
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn each_step_changes_one_channel_and_the_levels_say_where() {
        for code in [Code::Quadrature, Code::Hall, Code::OneChannel] {
            for state in 0..code.states() {
                assert_eq!(code.state(code.levels(state)), Some(state));
                let changed = code.levels(state) ^ code.levels(state + 1);
                assert_eq!(changed.count_ones(), 1, "{code:?} {state}");
                assert_eq!(1 << code.channel(state, 1), changed);
                assert_eq!(code.channel(state + 1, -1), code.channel(state, 1));
            }
        }
        assert_eq!(Code::Hall.state(7), None);
    }
}
