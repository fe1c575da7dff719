//! Effects of the catalogue, drawn with any size: the ideal detector sets it.

use std::f64::consts::TAU;

use super::rigs::Shape;
use crate::effect::Effect;
use crate::encoder::Encoder;
use crate::random::Dice;
use crate::rig::{Order, Profile, Rig};

/// Ids that single effects are drawn from.
pub const CATALOGUE: [&str; 26] = [
    "eccentricity",
    "disc_tilt",
    "local_defect",
    "edge_delay",
    "channel_skew",
    "width_error",
    "quadrature_error",
    "line_error",
    "threshold_ripple",
    "threshold_drift",
    "torque_ripple",
    "gear_mesh",
    "bearing",
    "torque_tone",
    "load_step",
    "speed_drift",
    "friction",
    "timestamp_jitter",
    "capture_latency",
    "lost_edges",
    "extra_edges",
    "index_slip",
    "hysteresis",
    "torsional_resonance",
    "closed_loop",
    "stick_slip",
];

/// Speeds at which an effect can be told from its look-alikes.
#[must_use]
pub fn shape(dice: &mut Dice, id: &str) -> Shape {
    use Shape::{Constant, Ramp, Reversal, RunDown, TwoSpeeds};
    match id {
        "local_defect" | "line_error" => dice.pick(&[Constant, TwoSpeeds, Ramp]),
        "load_step" | "speed_drift" | "threshold_drift" | "lost_edges" | "extra_edges"
        | "index_slip" | "stick_slip" => Constant,
        "timestamp_jitter" | "capture_latency" => dice.pick(&[TwoSpeeds, Ramp]),
        "friction" => RunDown,
        "hysteresis" | "backlash" => Reversal,
        "torsional_resonance" | "closed_loop" => TwoSpeeds,
        _ => dice.pick(&[TwoSpeeds, TwoSpeeds, Ramp]),
    }
}

/// Whether an encoder can show an effect.
#[must_use]
pub fn fits(id: &str, encoder: Encoder) -> bool {
    match id {
        "channel_skew" | "quadrature_error" => matches!(encoder, Encoder::Quadrature { .. }),
        "index_slip" => encoder.index(),
        "local_defect" => encoder.edges() >= 100,
        "stick_slip" => encoder.edges() >= 1000,
        // A loop that sees one edge in a while is another thing altogether.
        "closed_loop" => encoder.edges() >= 400,
        "torsional_resonance" => encoder.edges() >= 200,
        _ => true,
    }
}

/// An effect of an id for the rigs of a case.
#[must_use]
pub fn effect(dice: &mut Dice, id: &str, rigs: &[Rig]) -> Effect {
    let rig = &rigs[0];
    let speed = slowest(rigs);
    let step = rig.encoder.step_rad();
    let long = rigs.iter().map(run_s).fold(f64::INFINITY, f64::min);
    let phase_rad = dice.between(0.0, TAU);
    let angle_rad = 0.01 * step;
    let edges = rig.encoder.edges() as f64;
    // A frequency well below that of the edges at the lowest speed, and of some cycles at least.
    let f_hz = dice.log_between(8.0 / long, (0.1 * edges * speed / TAU).min(2000.0));
    match id {
        "eccentricity" => Effect::Eccentricity {
            amplitude_rad: angle_rad,
            phase_rad,
        },
        "disc_tilt" => Effect::DiscTilt {
            amplitude_rad: angle_rad,
            phase_rad,
        },
        "local_defect" => Effect::LocalDefect {
            angle_rad: phase_rad,
            width_rad: step * dice.log_between(2.0, 20.0),
            error_rad: dice.sign() * angle_rad,
            channel: dice
                .chance(0.6)
                .then(|| dice.whole(0, rig.encoder.channels() as u32 - 1) as usize),
            rises: dice.chance(0.4).then(|| dice.chance(0.5)),
        },
        "line_error" => Effect::LineError {
            rms_rad: angle_rad,
            seed: dice.seed(),
        },
        "width_error" => Effect::WidthError {
            rad: [1.0, dice.between(-1.0, 1.0), dice.between(-1.0, 1.0)]
                .map(|share| share * angle_rad)
                .map(|rad| if rad == 0.0 { angle_rad } else { rad }),
        },
        "quadrature_error" => Effect::QuadratureError {
            rad: dice.sign() * angle_rad,
        },
        "edge_delay" => {
            let late = [angle_rad / speed; 3];
            let (rise_s, fall_s) = if dice.chance(0.5) {
                (late, [0.0; 3])
            } else {
                ([0.0; 3], late)
            };
            Effect::EdgeDelay { rise_s, fall_s }
        }
        "channel_skew" => {
            let mut channel_s = [0.0; 3];
            channel_s[dice.whole(0, 1) as usize] = angle_rad / speed;
            Effect::ChannelSkew { channel_s }
        }
        "threshold_ripple" => Effect::ThresholdRipple {
            f_hz: if dice.chance(0.4) {
                dice.pick(&[50.0, 60.0, 100.0, 120.0])
            } else {
                f_hz
            },
            phase_rad,
            angle_rad,
            channel: (rig.encoder.channels() > 1 && dice.chance(0.3)).then_some(0),
        },
        "threshold_drift" => Effect::ThresholdDrift {
            angle_rad: dice.sign() * angle_rad,
            tau_s: long * dice.between(0.1, 0.5),
            from_s: long * dice.between(0.0, 0.4),
        },
        "torque_ripple" => {
            let top = (edges / 20.0).clamp(2.0, 48.0) as u32;
            let taken = |order: u32| rig.ripples.iter().any(|r| r.order == f64::from(order));
            let order = loop {
                let order = dice.whole(1, top);
                if !taken(order) {
                    break order;
                }
            };
            Effect::TorqueRipple(order_of(rig, f64::from(order), phase_rad, speed))
        }
        "gear_mesh" => {
            let order = non_integer(dice, edges);
            Effect::GearMesh(order_of(rig, order, phase_rad, speed))
        }
        "bearing" => {
            let order = non_integer(dice, edges);
            if dice.chance(0.5) {
                Effect::BearingTorque(order_of(rig, order, phase_rad, speed))
            } else {
                Effect::BearingRunout {
                    order,
                    phase_rad,
                    runout_rad: angle_rad,
                }
            }
        }
        "torque_tone" => {
            let f_hz = f_hz.min(300.0);
            Effect::TorqueTone {
                f_hz,
                phase_rad,
                torque_n_m: 1e-3 * rig.inertia * speed * TAU * f_hz,
            }
        }
        "load_step" => {
            let from_s = long * dice.between(0.2, 0.6);
            Effect::LoadStep {
                torque_n_m: dice.sign() * 1e-3 * speed * rig.inertia * rig.damping(true),
                from_s,
                until_s: from_s + long * dice.between(0.1, 0.3),
            }
        }
        "speed_drift" => Effect::SpeedDrift {
            fraction_per_s: dice.sign() * 1e-3 / long,
        },
        "friction" => friction(dice, rig, speed),
        "torsional_resonance" => Effect::TorsionalResonance {
            f_hz: dice.log_between(10.0 * speed / TAU, 0.1 * edges * speed / TAU),
            damping_ratio: dice.log_between(0.005, 0.05),
            inertia_share: 0.05,
        },
        "timestamp_jitter" => Effect::TimestampJitter {
            jitter_s: rig.jitter_s,
        },
        "capture_latency" if dice.chance(0.5) => Effect::CaptureLatency {
            mean_s: rig.jitter_s,
        },
        "capture_latency" => {
            let task_hz = dice.pick(&[500.0, 1000.0, 2000.0, 4000.0, 8000.0]) * 1.000_03;
            Effect::CaptureTask {
                task_hz,
                busy_s: 0.1 / task_hz,
                phase_s: dice.unit() / task_hz,
            }
        }
        "lost_edges" => Effect::LostEdges {
            count: 1,
            seed: dice.seed(),
        },
        "extra_edges" => Effect::ExtraEdges {
            count: 1,
            seed: dice.seed(),
        },
        "index_slip" => Effect::IndexSlip {
            at_s: long * dice.between(0.2, 0.7),
            edges: if dice.chance(0.5) { 1 } else { -1 },
        },
        "hysteresis" => Effect::Hysteresis { angle_rad },
        "stick_slip" => stick_slip(dice, rig, speed),
        "backlash" => Effect::Backlash { gap_rad: angle_rad },
        _ => {
            let hz = dice.log_between(2.0, 10.0);
            let kp_n_m_s = rig.inertia * TAU * hz;
            Effect::ClosedLoop {
                kp_n_m_s,
                ki_n_m: kp_n_m_s * TAU * hz / 6.0,
                f_hz: (50.0 * hz).min(speed / step / 3.0),
            }
        }
    }
}

/// A limit cycle that takes a good part of a turn: the shaft sticks until the spring is wound up, and slips.
fn stick_slip(dice: &mut Dice, rig: &Rig, speed: f64) -> Effect {
    // Half the swing of a free slip is the drop of friction over the spring: here some turns' hundredths.
    let stiffness_n_m_rad = rig.inertia * (speed * dice.between(6.0, 15.0)).powi(2);
    let drop = stiffness_n_m_rad * dice.between(0.1, 0.3);
    Effect::StickSlip {
        stiffness_n_m_rad,
        coulomb_n_m: drop * dice.between(0.5, 1.5),
        stribeck_n_m: drop,
        stribeck_rad_s: speed * dice.between(0.3, 0.6),
    }
}

fn friction(dice: &mut Dice, rig: &Rig, speed: f64) -> Effect {
    let whole = 1e-3 * rig.viscous * speed;
    let which = dice.whole(0, 3);
    let only = |at: u32, size: f64| if at == which { size } else { 0.0 };
    Effect::Friction {
        coulomb_n_m: only(0, whole),
        viscous_n_m_s: only(1, whole / speed),
        drag_n_m_s2: only(2, whole / (speed * speed)),
        stribeck_n_m: only(3, whole),
        stribeck_rad_s: speed * dice.between(0.4, 0.7),
    }
}

/// Least of the speeds that rigs turn at for long, rad/s.
#[must_use]
pub fn slowest(rigs: &[Rig]) -> f64 {
    let slow = rigs.iter().map(|rig| match rig.profile {
        Profile::Ramp { from, to, .. } if from * to > 0.0 => from.min(to),
        _ => rig.profile.top(),
    });
    slow.fold(f64::INFINITY, f64::min)
}

/// About how long a run takes, s.
#[must_use]
pub fn run_s(rig: &Rig) -> f64 {
    match rig.profile {
        Profile::Ramp { from, to, .. } if from * to > 0.0 => {
            rig.turns * TAU / (0.5 * (from + to).abs())
        }
        _ => rig.turns * TAU / rig.profile.top(),
    }
}

/// A torque at an order that swings the speed by a thousandth.
pub fn order_of(rig: &Rig, order: f64, phase_rad: f64, speed: f64) -> Order {
    Order {
        order,
        phase_rad,
        torque_n_m: 1e-3 * rig.inertia * order * speed * speed,
    }
}

/// An order well away from integers.
pub fn non_integer(dice: &mut Dice, edges: f64) -> f64 {
    let whole = f64::from(dice.whole(0, (edges / 20.0).clamp(2.0, 40.0) as u32));
    whole + dice.between(0.2, 0.8)
}
