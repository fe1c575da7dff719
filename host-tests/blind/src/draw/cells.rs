//! Sixty effects in no catalogue: every site with every carrier and growth that no catalogue puts together.

use std::f64::consts::TAU;

use super::effects::{non_integer, run_s, slowest};
use super::rigs::Shape;
use crate::effect::{Carrier, Cell, Effect, Growth, Site};
use crate::encoder::Encoder;
use crate::random::Dice;
use crate::rig::Rig;

/// Switches of jumps and bursts in a run, on average.
const SWITCHES: f64 = 12.0;

const SITES: [Site; 4] = [Site::Torque, Site::Disc, Site::Level, Site::Stamp];

/// What an effect follows and how it grows, without numbers.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Follows {
    Order,
    Tone,
    Place,
    Sweep,
    Jumps,
    Steady,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Grows {
    Not,
    WithTime,
    Modulated,
    WithSpeed,
    InBursts,
}

/// Carriers with growths: those of the catalogue are the ones that do not grow.
const ROWS: [(Follows, Grows); 15] = [
    (Follows::Order, Grows::WithTime),
    (Follows::Order, Grows::Modulated),
    (Follows::Order, Grows::WithSpeed),
    (Follows::Order, Grows::InBursts),
    (Follows::Tone, Grows::WithTime),
    (Follows::Tone, Grows::Modulated),
    (Follows::Tone, Grows::WithSpeed),
    (Follows::Tone, Grows::InBursts),
    (Follows::Place, Grows::WithTime),
    (Follows::Place, Grows::Modulated),
    (Follows::Place, Grows::WithSpeed),
    (Follows::Place, Grows::InBursts),
    (Follows::Sweep, Grows::Not),
    (Follows::Jumps, Grows::Not),
    (Follows::Steady, Grows::WithSpeed),
];

/// Step from one number's combination to the next; shares no factor with how many there are.
const STRIDE: usize = 37;

/// How many there are.
pub const COUNT: usize = SITES.len() * ROWS.len();

/// Sites and rows of neighbouring numbers differ, so that few cases have many of both.
fn cell(which: usize) -> (Site, Follows, Grows) {
    let which = which * STRIDE % COUNT;
    let (follows, grows) = ROWS[which / SITES.len()];
    (SITES[which % SITES.len()], follows, grows)
}

/// Speeds that show the effect of a number: at one speed alone, sites and carriers of the catalogue are not told apart.
pub(super) fn shape(which: usize) -> Shape {
    match cell(which).2 {
        Grows::WithSpeed => Shape::Ramp,
        _ => Shape::TwoSpeeds,
    }
}

/// Whether an encoder can show the effect of a number: where all edges alike are late, no other channel tells of it.
pub(super) fn fits(which: usize, encoder: Encoder) -> bool {
    encoder.edges() >= 200 && (one_channel(which).is_none() || encoder.channels() > 1)
}

/// A stamp is late on A alone; so is a disc that goes with nothing but the speed.
fn one_channel(which: usize) -> Option<usize> {
    let (site, follows, _) = cell(which);
    let alike = site == Site::Stamp || (site == Site::Disc && follows == Follows::Steady);
    alike.then_some(0)
}

/// The effect of a number, with any size.
pub(super) fn effect(dice: &mut Dice, which: usize, rigs: &[Rig]) -> Effect {
    let (site, follows, grows) = cell(which);
    let rig = &rigs[0];
    let speed = slowest(rigs);
    let long = run_s(rig);
    let edges = rig.encoder.edges() as f64;
    let step = rig.encoder.step_rad();
    let phase_rad = dice.between(0.0, TAU);
    let f_hz = dice.log_between(20.0 / long, (0.02 * edges * speed / TAU).max(25.0 / long));
    let carrier = match follows {
        Follows::Order => Carrier::Order {
            order: if dice.chance(0.5) {
                f64::from(dice.whole(1, 4))
            } else {
                non_integer(dice, 0.5 * edges)
            },
            phase_rad,
        },
        Follows::Tone => Carrier::Tone { f_hz, phase_rad },
        Follows::Place => Carrier::Place {
            angle_rad: phase_rad,
            width_rad: (step * dice.log_between(3.0, 20.0)).min(0.3),
        },
        Follows::Sweep => Carrier::Sweep {
            f_hz,
            rate_hz_s: f_hz * dice.between(0.5, 1.5) / long,
        },
        Follows::Jumps => Carrier::Jumps,
        Follows::Steady => Carrier::Steady,
    };
    let growth = match grows {
        Grows::Not => Growth::Constant,
        Grows::WithTime => Growth::Linear { over_s: long },
        Grows::Modulated => Growth::Modulated {
            f_hz: dice.between(2.0, 8.0) / long,
        },
        Grows::WithSpeed => Growth::SpeedCubed {
            at_rad_s: rig.profile.top(),
        },
        Grows::InBursts => Growth::Bursts,
    };
    let switches_s = match (follows, grows) {
        (Follows::Jumps, _) | (_, Grows::InBursts) => {
            switches(dice, SWITCHES / long, rig.longest_s)
        }
        _ => Vec::new(),
    };
    Effect::Cell(Cell {
        site,
        carrier,
        growth,
        channel: one_channel(which),
        switches_s,
        size: match site {
            Site::Torque => torque(rig, carrier, speed),
            Site::Disc | Site::Level => 0.01 * step,
            Site::Stamp => 0.01 * step / speed,
        },
    })
}

/// Instants at random, s.
fn switches(dice: &mut Dice, rate_hz: f64, until_s: f64) -> Vec<f64> {
    let mut all = Vec::new();
    let mut at = dice.exponential() / rate_hz;
    while at < until_s {
        all.push(at);
        at += dice.exponential() / rate_hz;
    }
    all
}

/// A torque that changes the speed by about a thousandth.
fn torque(rig: &Rig, carrier: Carrier, speed: f64) -> f64 {
    let quick = match carrier {
        Carrier::Order { order, .. } => order * speed,
        Carrier::Tone { f_hz, .. } | Carrier::Sweep { f_hz, .. } => TAU * f_hz,
        Carrier::Place { width_rad, .. } => speed / width_rad,
        Carrier::Jumps | Carrier::Steady => rig.damping(true),
    };
    1e-3 * rig.inertia * speed * quick
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn sixty_combinations_come_out_each_once() {
        let mut all: Vec<String> = (0..COUNT)
            .map(|which| format!("{:?}", cell(which)))
            .collect();
        all.sort();
        all.dedup();
        assert_eq!(all.len(), 60);
        for which in 0..COUNT {
            let (_, follows, grows) = cell(which);
            let alone = matches!(follows, Follows::Sweep | Follows::Jumps);
            assert!(alone || grows != Grows::Not, "{which} is the catalogue's");
        }
    }
}
