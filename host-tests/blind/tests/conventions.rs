//! What the truth and a twin call a parameter is the same: an effect of the generator moves edges as the twin's section of the same
//! numbers does, sign, phase and origin of time and angle included.

use std::f64::consts::TAU;

use quadcal_blind::capture::rows;
use quadcal_blind::effect::Effect;
use quadcal_blind::encoder::Encoder;
use quadcal_blind::rig::{Order, Profile, Rig};
use quadcal_blind::turning::turn;
use quadcal_blind::write;
use quadcal_host::sim::Simulation;
use quadcal_host::twin::{
    Backlash, Bearing, CaptureLatency, Channel, ChannelSkew, EdgeDelay, Flank, Harmonic,
    Hysteresis, IndexSlip, LoadStep, LocalDefect, Ripple, RiseFall, SpeedDrift, ThresholdDrift,
    ThresholdRipple, TorqueTone, TorsionalResonance, Twin,
};

const CLOCK_HZ: u64 = 1_000_000_000;

fn rig(profile: Profile) -> Rig {
    let encoder = Encoder::Quadrature {
        lines: 250,
        index: true,
    };
    Rig {
        encoder,
        disc_rad: vec![0.0; encoder.edges()],
        disc_known: false,
        inertia: 1e-4,
        viscous: 1e-4,
        coulomb: 0.0,
        stiffness: 4e-4,
        start_rad: 2.303,
        ripples: Vec::new(),
        noise_psd: 0.0,
        jitter_s: 0.0,
        noise_known: false,
        clock_hz: CLOCK_HZ,
        profile,
        turns: 4.0,
        longest_s: 60.0,
    }
}

fn steady() -> Rig {
    rig(Profile::Constant { speed: 20.0 })
}

fn back_and_forth() -> Rig {
    rig(Profile::Ramp {
        from: 20.0,
        to: -20.0,
        over_s: 1.5,
    })
}

/// Ticks and levels of a rig with effects, by the generator.
fn ours(rig: &Rig, effects: &[Effect]) -> Vec<(u64, u8)> {
    let rows = rows(&turn(rig, effects, None), rig, effects, 0).0;
    // The generator's bit of the index is 8, with C between; a recording's is 4.
    let levels = |bits: u8| (bits & 3) | ((bits & 8) >> 1);
    rows.into_iter()
        .map(|(ticks, bits)| (ticks, levels(bits)))
        .collect()
}

/// Ticks and levels of its twin with sections added, by the simulator.
fn theirs(rig: &Rig, add: impl Fn(&mut Twin)) -> Vec<(u64, u8)> {
    let mut twin = Twin::parse(&write::twin(rig), "twin.toml").unwrap();
    twin.shaft.initial_angle_rad = rig.start_rad;
    add(&mut twin);
    let events = Simulation::new(&twin).unwrap();
    events
        .map(|event| (event.row.ticks, event.row.levels.0))
        .collect()
}

/// Largest difference of times, ticks, row for row; the same levels in the same order.
fn furthest(one: &[(u64, u8)], other: &[(u64, u8)]) -> f64 {
    let count = one.len().min(other.len());
    assert!(one.len().abs_diff(other.len()) < 100 && count > 400);
    let pairs = one.iter().zip(other);
    pairs.fold(0.0, |most, (a, b)| {
        assert_eq!(a.1, b.1, "levels at {} and {} ticks", a.0, b.0);
        (a.0.abs_diff(b.0) as f64).max(most)
    })
}

/// Holds generator and simulator against each other: they agree to a share of what the effect does at all, and a tick or two.
fn agree(rig: &Rig, effects: &[Effect], add: impl Fn(&mut Twin)) {
    let with = ours(rig, effects);
    let off = furthest(&with, &theirs(rig, add));
    let without = ours(rig, &[]);
    let pairs = with.iter().zip(&without);
    let moved = pairs.fold(0, |most, (a, b)| most.max(a.0.abs_diff(b.0))) as f64;
    assert!(
        moved > 300.0,
        "the effect moves edges by {moved} ticks only"
    );
    assert!(off <= 2.0 + 2e-3 * moved, "{off} of {moved} ticks");
}

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
fn errors_of_the_disc() {
    let (amplitude_rad, phase_rad) = (1e-3, 0.7);
    let harmonic = Some(Harmonic {
        amplitude_rad,
        phase_rad,
    });
    let eccentricity = Effect::Eccentricity {
        amplitude_rad,
        phase_rad,
    };
    agree(&steady(), &[eccentricity], |twin| {
        twin.errors.eccentricity = harmonic;
    });
    let tilt = Effect::DiscTilt {
        amplitude_rad,
        phase_rad,
    };
    agree(&steady(), &[tilt], |twin| twin.errors.tilt = harmonic);
    let rad = [1e-3, -5e-4, 0.0];
    agree(&steady(), &[Effect::WidthError { rad }], |twin| {
        (twin.errors.width_a_rad, twin.errors.width_b_rad) = (rad[0], rad[1]);
    });
    let quadrature = Effect::QuadratureError { rad: 8e-4 };
    agree(&steady(), &[quadrature], |twin| {
        twin.errors.quadrature_rad = 8e-4;
    });
    let defect = Effect::LocalDefect {
        angle_rad: 1.2,
        width_rad: 0.05,
        error_rad: -1e-3,
        channel: Some(1),
        rises: Some(false),
    };
    agree(&steady(), &[defect], |twin| {
        twin.local_defect = vec![LocalDefect {
            angle_rad: 1.2,
            width_rad: 0.05,
            error_rad: -1e-3,
            channel: Some(Channel::B),
            edge: Some(Flank::Fall),
        }];
    });
}

#[test]
fn delays_count_by_the_level_that_changes_in_reverse_too() {
    let delay = Effect::EdgeDelay {
        rise_s: [2e-5, 1e-5, 0.0],
        fall_s: [0.0, 3e-5, 0.0],
    };
    let skew = Effect::ChannelSkew {
        channel_s: [0.0, 2e-5, 0.0],
    };
    let both = |rise_s, fall_s| RiseFall { rise_s, fall_s };
    for rig in [steady(), back_and_forth()] {
        agree(&rig, std::slice::from_ref(&delay), |twin| {
            twin.edge_delay = Some(EdgeDelay {
                a: both(2e-5, 0.0),
                b: both(1e-5, 3e-5),
                c: RiseFall::default(),
            });
        });
        agree(&rig, std::slice::from_ref(&skew), |twin| {
            twin.channel_skew = Some(ChannelSkew {
                b_s: 2e-5,
                ..ChannelSkew::default()
            });
        });
    }
}

#[test]
fn levels_move_the_same_way() {
    let ripple = Effect::ThresholdRipple {
        f_hz: 50.0,
        phase_rad: 0.4,
        angle_rad: 5e-4,
        channel: Some(0),
    };
    agree(&steady(), &[ripple], |twin| {
        twin.threshold_ripple = Some(ThresholdRipple {
            f_hz: 50.0,
            phase_rad: 0.4,
            angle_rad: 5e-4,
            channel: Some(Channel::A),
        });
    });
    let drift = Effect::ThresholdDrift {
        angle_rad: -5e-4,
        tau_s: 0.2,
        from_s: 0.3,
    };
    agree(&steady(), &[drift], |twin| {
        twin.threshold_drift = Some(ThresholdDrift {
            angle_rad: -5e-4,
            tau_s: 0.2,
            from_s: 0.3,
            channel: None,
        });
    });
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
                let quadcal_host::twin::Drive::RunDown { r_min, .. } = &mut twin.drive else {
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

#[test]
fn plays_of_the_same_angle_after_a_reversal() {
    let rig = back_and_forth();
    agree(&rig, &[Effect::Hysteresis { angle_rad: 2e-3 }], |twin| {
        twin.hysteresis = Some(Hysteresis {
            angle_rad: 2e-3,
            channel: None,
        });
    });
    agree(&rig, &[Effect::Backlash { gap_rad: 2e-3 }], |twin| {
        twin.backlash = Some(Backlash { gap_rad: 2e-3 });
    });
}

#[test]
fn a_task_blocks_captures_at_the_same_times() {
    let task = Effect::CaptureTask {
        task_hz: 1000.0,
        busy_s: 5e-5,
        phase_s: 3e-4,
    };
    agree(&steady(), &[task], |twin| {
        twin.capture_latency = Some(CaptureLatency {
            mean_s: None,
            task_hz: Some(1000.0),
            busy_s: Some(5e-5),
            phase_s: Some(3e-4),
        });
    });
}

#[test]
fn an_index_slips_to_the_same_side() {
    for edges in [2, -3] {
        let slip = Effect::IndexSlip { at_s: 0.4, edges };
        agree(&steady(), &[slip], |twin| {
            twin.index_slip = vec![IndexSlip { at_s: 0.4, edges }];
        });
    }
}
