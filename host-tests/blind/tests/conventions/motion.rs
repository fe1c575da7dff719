//! What pushes the shaft.

use std::f64::consts::TAU;

use quadcal_blind::effect::Effect;
use quadcal_blind::rig::{Order, Profile};
use quadcal_host::twin::{
    Bearing, Drive, LoadStep, Ripple, SpeedDrift, TorqueTone, TorsionalResonance,
};

use crate::{agree, furthest, ours, rig, steady, theirs};

fn order(order: f64) -> (Order, Ripple) {
    let (phase_rad, torque_n_m) = (0.7, 1e-4);
    (
        Order {
            order,
            phase_rad,
            torque_n_m,
        },
        Ripple {
            order,
            phase_rad,
            torque_n_m: Some(torque_n_m),
            speed_fraction: None,
        },
    )
}

#[test]
fn torques_and_run_out_by_angle() {
    let (whole, ripple) = order(3.0);
    agree(&steady(), &[Effect::TorqueRipple(whole)], |twin| {
        twin.ripple = vec![ripple];
    });
    let (part, mesh) = order(2.37);
    agree(&steady(), &[Effect::GearMesh(part)], |twin| {
        twin.gear_mesh = vec![mesh];
    });
    let bearing = Bearing {
        order: 2.37,
        phase_rad: 0.7,
        torque_n_m: Some(1e-4),
        speed_fraction: None,
        runout_rad: None,
    };
    agree(&steady(), &[Effect::BearingTorque(part)], |twin| {
        twin.bearing = vec![bearing];
    });
    let runout = Effect::BearingRunout {
        order: 2.37,
        phase_rad: 0.7,
        runout_rad: 1e-3,
    };
    // Its angle is the shaft's here and the grid's there, a small run-out apart.
    agree(&steady(), &[runout], |twin| {
        twin.bearing = vec![Bearing {
            torque_n_m: None,
            runout_rad: Some(1e-3),
            ..bearing
        }];
    });
}

#[test]
fn torques_by_time() {
    let tone = Effect::TorqueTone {
        f_hz: 7.0,
        phase_rad: 0.9,
        torque_n_m: 1e-4,
    };
    agree(&steady(), &[tone], |twin| {
        twin.torque_tone = vec![TorqueTone {
            f_hz: 7.0,
            phase_rad: 0.9,
            torque_n_m: Some(1e-4),
            speed_fraction: None,
        }];
    });
    let load = Effect::LoadStep {
        torque_n_m: -2e-4,
        from_s: 0.3,
        until_s: 0.6,
    };
    let section = LoadStep {
        torque_n_m: -2e-4,
        from_s: 0.3,
        until_s: Some(0.6),
    };
    agree(&steady(), std::slice::from_ref(&load), |twin| {
        twin.load_step = vec![section];
    });
    // The load wakes the mode, from a shaft that turns evenly in both.
    let mode = Effect::TorsionalResonance {
        f_hz: 30.0,
        damping_ratio: 0.02,
        inertia_share: 0.2,
    };
    agree(&steady(), &[mode, load], |twin| {
        twin.load_step = vec![section];
        twin.torsional_resonance = Some(TorsionalResonance {
            f_hz: 30.0,
            damping_ratio: 0.02,
            inertia_share: 0.2,
            load_psd_n2_m2_s: None,
            load_hold_s: None,
        });
    });
    let drift = Effect::SpeedDrift {
        fraction_per_s: -2e-3,
    };
    agree(&steady(), &[drift], |twin| {
        twin.speed_drift = Some(SpeedDrift {
            fraction_per_s: Some(-2e-3),
            ..SpeedDrift::default()
        });
    });
}

#[test]
fn friction_shapes_a_run_down_the_same_way() {
    let (viscous, speed) = (1e-4, 30.0);
    let terms = [
        (2e-4, 0.0, 0.0, 0.0),
        (0.0, 1e-5, 0.0, 0.0),
        (0.0, 0.0, 3e-7, 0.0),
        (0.0, 0.0, 0.0, 4e-4),
    ];
    for (coulomb_n_m, viscous_n_m_s, drag_n_m_s2, stribeck_n_m) in terms {
        let mut rig = rig(Profile::RunDown { speed, off_s: 0.1 });
        rig.turns = 3.0;
        let stribeck_rad_s = 25.0;
        let more = Effect::Friction {
            coulomb_n_m,
            viscous_n_m_s,
            drag_n_m_s2,
            stribeck_n_m,
            stribeck_rad_s,
        };
        // The generator's drive knows nothing of it and sags; a twin's drive balances all friction, so it is asked for less. What a
        // run starts at is first order in the friction there: here it is made to settle before the drive goes off.
        let sagged = (0..60).fold(speed, |at: f64, _| {
            let over = at / stribeck_rad_s;
            let against = coulomb_n_m
                + viscous_n_m_s * at
                + drag_n_m_s2 * at * at
                + stribeck_n_m * (-over * over).exp();
            speed - against / (viscous + rig.stiffness)
        });
        rig.profile = Profile::RunDown { speed, off_s: 0.02 };
        let with = ours(&rig, &[more]);
        let off = furthest(
            &with,
            &theirs(&rig, |twin| {
                let Drive::RunDown { r_min, .. } = &mut twin.drive else {
                    panic!("a run-down");
                };
                *r_min = sagged * 60.0 / TAU;
                twin.shaft.coulomb_n_m += coulomb_n_m;
                twin.shaft.viscous_n_m_s += viscous_n_m_s;
                twin.shaft.drag_n_m_s2 += drag_n_m_s2;
                twin.shaft.stribeck_n_m += stribeck_n_m;
                if stribeck_n_m > 0.0 {
                    twin.shaft.stribeck_rad_s = stribeck_rad_s;
                }
            }),
        );
        let without = ours(&rig, &[]);
        let moved = with
            .iter()
            .zip(&without)
            .fold(0, |most, (a, b)| most.max(a.0.abs_diff(b.0)));
        assert!(off < 0.05 * moved as f64, "{off} of {moved} ticks");
    }
}
