//! Each mechanism with ten times finer steps.

use super::motion::largest_angle_difference;
use super::*;
use crate::twin::{
    Backlash, Bearing, Hysteresis, SpeedDrift, StickSlip, ThresholdDrift, ThresholdRipple,
    TorqueTone, TorsionalResonance,
};

fn tone(f_hz: f64) -> TorqueTone {
    TorqueTone {
        f_hz,
        phase_rad: 0.3,
        torque_n_m: None,
        speed_fraction: Some(0.01),
    }
}

/// Rigs with one mechanism each, at a speed.
fn rigs(r_min: f64) -> Vec<(&'static str, Twin)> {
    let base = Twin {
        drive: Drive::Constant { r_min },
        duration: Duration::Turns(2.0),
        ..Twin::paper()
    };
    let with = |change: &dyn Fn(&mut Twin)| {
        let mut twin = base.clone();
        change(&mut twin);
        twin
    };
    let turn_s = 60.0 / r_min;
    vec![
        (
            "tone",
            with(&|t| t.torque_tone = vec![tone(50.0), tone(1237.0)]),
        ),
        (
            "gear",
            with(&|t| {
                t.gear_mesh = vec![Ripple {
                    order: 17.3,
                    phase_rad: 1.0,
                    torque_n_m: None,
                    speed_fraction: Some(0.02),
                }];
            }),
        ),
        (
            "run-out",
            with(&|t| {
                t.bearing = vec![Bearing {
                    order: 3.1,
                    phase_rad: 1.0,
                    torque_n_m: None,
                    speed_fraction: None,
                    runout_rad: Some(1e-3),
                }];
            }),
        ),
        (
            "threshold ripple",
            with(&|t| {
                t.threshold_ripple = vec![ThresholdRipple {
                    f_hz: 50.0,
                    phase_rad: 0.0,
                    angle_rad: 1e-4,
                    channel: None,
                }];
            }),
        ),
        (
            "threshold drift",
            with(&|t| {
                t.threshold_drift = vec![ThresholdDrift {
                    angle_rad: 1e-4,
                    tau_s: turn_s,
                    from_s: 0.3 * turn_s,
                    channel: None,
                }];
            }),
        ),
        (
            "hysteresis and backlash on a reversal",
            with(&|t| {
                t.hysteresis = Some(Hysteresis {
                    angle_rad: 1e-4,
                    channel: None,
                });
                t.backlash = Some(Backlash { gap_rad: 0.02 });
                t.drive = Drive::Ramp {
                    from_r_min: r_min,
                    to_r_min: -r_min,
                    over_s: 3.0 * turn_s,
                };
                t.shaft.stiffness_n_m_s = 1e-3 / turn_s;
            }),
        ),
        (
            "speed drift on a ramp",
            with(&|t| {
                t.speed_drift = Some(SpeedDrift {
                    fraction_per_s: None,
                    fraction: Some(0.1),
                    tau_s: Some(turn_s),
                });
                t.drive = Drive::Ramp {
                    from_r_min: 0.3 * r_min,
                    to_r_min: r_min,
                    over_s: turn_s,
                };
            }),
        ),
        (
            "drag and Stribeck friction on a run-down",
            with(&|t| {
                let w = r_min * RAD_S;
                t.shaft.coulomb_n_m = 1e-5 * w * w;
                t.shaft.drag_n_m_s2 = 1e-5;
                t.shaft.stribeck_n_m = 1e-5 * w * w;
                t.shaft.stribeck_rad_s = 0.1 * w;
                t.drive = Drive::RunDown {
                    r_min,
                    off_s: 0.5 * turn_s,
                };
                t.duration = Duration::Seconds(5.0 * turn_s);
                t.torque_tone = vec![tone(3.0 / turn_s)];
            }),
        ),
        (
            "resonance that noise excites",
            with(&|t| {
                t.torsional_resonance = Some(TorsionalResonance {
                    f_hz: 20.0 / turn_s,
                    damping_ratio: 0.01,
                    inertia_share: 0.4,
                    load_psd_n2_m2_s: Some(1e-12),
                    load_hold_s: None,
                });
                t.noise = wander(1e-3);
            }),
        ),
        (
            "resonance that sticks and slips",
            with(&|t| {
                t.torsional_resonance = Some(TorsionalResonance {
                    f_hz: 20.0 / turn_s,
                    damping_ratio: 0.01,
                    inertia_share: 0.4,
                    load_psd_n2_m2_s: None,
                    load_hold_s: None,
                });
                let w = r_min * RAD_S;
                t.shaft.coulomb_n_m = 1e-4 * w * w;
                t.shaft.stiffness_n_m_s = 1e-4 * w;
                t.torque_tone = vec![TorqueTone {
                    speed_fraction: None,
                    torque_n_m: Some(5e-4 * w * w),
                    ..tone(5.0 / turn_s)
                }];
            }),
        ),
        (
            "stick-slip",
            with(&|t| {
                let w = r_min * RAD_S;
                t.ripple.clear();
                t.shaft.viscous_n_m_s = 1e-6 * w;
                t.shaft.coulomb_n_m = 1e-4 * w * w;
                t.shaft.stribeck_n_m = 1e-4 * w * w;
                t.shaft.stribeck_rad_s = w;
                t.stick_slip = Some(StickSlip {
                    stiffness_n_m_rad: 1e-3 * w * w,
                });
            }),
        ),
    ]
}

#[test]
fn ten_times_finer_steps_move_no_edge_by_1e_minus_10_rad_whatever_the_mechanism() {
    for r_min in [15.0, 1500.0] {
        for (name, twin) in rigs(r_min) {
            let largest = largest_angle_difference(&twin, r_min);
            assert!(largest <= 1e-10, "{name} at {r_min} r/min: {largest:e} rad");
        }
    }
}
