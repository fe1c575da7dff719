//! What the truth and a twin call a parameter is the same: an effect of the generator moves edges as the twin's section of the same
//! numbers does, sign, phase and origin of time and angle included.

mod capture;
mod disc;
mod motion;

use quadcal_blind::capture::rows;
use quadcal_blind::effect::Effect;
use quadcal_blind::encoder::Encoder;
use quadcal_blind::rig::{NoiseShape, Profile, Rig, Told};
use quadcal_blind::turning::turn;
use quadcal_blind::write;
use quadcal_host::sim::Simulation;
use quadcal_host::twin::Twin;

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
        noise_shape: NoiseShape::White,
        told: Told::Whole,
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
