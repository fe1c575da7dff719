//! The generator's motion against the simulator that it shares no code with.

use std::f64::consts::TAU;

use quadcal_blind::encoder::Encoder;
use quadcal_blind::rig::{NoiseShape, Order, Profile, Rig, Told};
use quadcal_blind::turning::turn;
use quadcal_blind::write;
use quadcal_host::sim::Simulation;
use quadcal_host::twin::Twin;

fn rig(encoder: Encoder, profile: Profile) -> Rig {
    let edges = encoder.edges();
    let step = TAU / edges as f64;
    let disc = (0..edges).map(|k| 0.2 * step * ((k * k) as f64).sin());
    Rig {
        encoder,
        disc_rad: disc.collect(),
        disc_known: true,
        inertia: 1e-4,
        viscous: 1e-4,
        coulomb: 0.0,
        stiffness: 4e-4,
        start_rad: 0.3,
        ripples: Vec::new(),
        noise_psd: 0.0,
        jitter_s: 0.0,
        noise_known: false,
        noise_shape: NoiseShape::White,
        told: Told::Whole,
        clock_hz: 84_000_000,
        profile,
        turns: 4.0,
        longest_s: 60.0,
    }
}

/// Largest difference of edge angles, rad, time for time; both hold the same edges.
fn furthest(rig: &Rig) -> f64 {
    let folder = tempfile::tempdir().unwrap();
    write::open_folder(folder.path(), &[(rig.clone(), Vec::new())]).unwrap();
    let path = folder.path().join("twin.toml");
    let mut twin = Twin::load(&path).unwrap();
    twin.shaft.initial_angle_rad = rig.start_rad;
    let theirs: Vec<_> = Simulation::new(&twin).unwrap().collect();
    let ours = turn(rig, &[], None);
    let count = theirs.len().min(ours.crossings.len());
    assert!(theirs.len().abs_diff(ours.crossings.len()) < 200 && count > 400);
    let pairs = theirs.iter().zip(&ours.crossings);
    pairs.fold(0.0, |most, (their, our)| {
        let at = (their.truth.time_s - our.time_s) * our.speed;
        assert_eq!(their.truth.edge.is_some(), our.class.is_some());
        at.abs().max(most)
    })
}

const ENCODER: Encoder = Encoder::Quadrature {
    lines: 250,
    index: true,
};

fn order(order: f64, torque_n_m: f64) -> Order {
    Order {
        order,
        phase_rad: 0.4,
        torque_n_m,
    }
}

#[test]
fn constant_speed_with_ripple_agrees() {
    let mut rig = rig(ENCODER, Profile::Constant { speed: 20.0 });
    rig.ripples = vec![order(5.0, 1e-3), order(12.0, 6e-4)];
    assert!(furthest(&rig) < 1e-9, "{:e}", furthest(&rig));
}

#[test]
fn hall_and_wheel_agree() {
    for encoder in [
        Encoder::Hall { pole_pairs: 20 },
        Encoder::Wheel { teeth: 60 },
    ] {
        let mut rig = rig(encoder, Profile::Constant { speed: 20.0 });
        rig.ripples = vec![order(2.0, 1e-3)];
        rig.turns = 6.0;
        assert!(furthest(&rig) < 1e-9, "{:e}", furthest(&rig));
    }
}

#[test]
fn reversal_with_dry_friction_agrees() {
    let profile = Profile::Ramp {
        from: 20.0,
        to: -15.0,
        over_s: 2.0,
    };
    let mut rig = rig(ENCODER, profile);
    rig.coulomb = 3e-4;
    rig.ripples = vec![order(3.0, 1e-3)];
    assert!(furthest(&rig) < 1e-9, "{:e}", furthest(&rig));
}

#[test]
fn run_down_agrees() {
    let profile = Profile::RunDown {
        speed: 30.0,
        off_s: 0.3,
    };
    let mut rig = rig(ENCODER, profile);
    rig.coulomb = 8e-4;
    rig.turns = 5.0;
    assert!(furthest(&rig) < 1e-9, "{:e}", furthest(&rig));
}

#[test]
fn speed_loop_agrees() {
    let profile = Profile::Loop {
        speed: 20.0,
        f_hz: 5000.0,
        kp_n_m_s: 2e-2,
        ki_n_m: 0.3,
    };
    let mut rig = rig(ENCODER, profile);
    rig.stiffness = 0.0;
    rig.ripples = vec![order(5.0, 1e-3)];
    assert!(furthest(&rig) < 1e-9, "{:e}", furthest(&rig));
}
