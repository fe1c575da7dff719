use super::{DETECTABLE, Ideal};
use crate::effect::Effect;
use crate::rig::{Order, Profile, Rig};
use crate::testing::plain;
use crate::turning::turn_evenly;

fn noisy() -> Rig {
    Rig {
        jitter_s: 1e-6,
        stiffness: 2e-3,
        turns: 10.0,
        ..plain()
    }
}

fn edges(rig: &Rig) -> f64 {
    let count = rig.encoder.edges() as f64;
    rig.turns * count - 2.0 * (1.0 + (super::sight::END_RAD / rig.encoder.step_rad()).ceil())
}

const WIDTH: Effect = Effect::WidthError { rad: [1e-6; 3] };

#[test]
fn with_white_noise_alone_the_distance_is_the_signals_length_over_the_noise() {
    let rig = noisy();
    let distance = Ideal::new(std::slice::from_ref(&rig)).distance(&WIDTH);
    // Falls against rises: half the width on either side of the mean.
    let expected = 0.5e-6 * edges(&rig).sqrt() / (10.0 * rig.stamp_rms_s());
    assert!(
        (distance / expected - 1.0).abs() < 2e-3,
        "{distance} {expected}"
    );
}

#[test]
fn the_size_found_is_the_one_that_is_just_detectable() {
    let mut rig = noisy();
    rig.noise_psd = 2.0 * rig.damping(true) * (1e-3 * 10.0 * rig.inertia).powi(2);
    let rigs = [rig];
    let ideal = Ideal::new(&rigs);
    let tone = Effect::TorqueTone {
        f_hz: 20.0,
        phase_rad: 0.2,
        torque_n_m: 1e-4,
    };
    for effect in [WIDTH, tone, Effect::TimestampJitter { jitter_s: 1e-6 }] {
        let factor = ideal.factor(&effect).unwrap();
        let distance = ideal.distance(&effect.scaled(factor));
        assert!(
            (distance / DETECTABLE - 1.0).abs() < 0.01,
            "{effect:?} {distance}"
        );
    }
}

#[test]
fn slow_effects_hide_under_wander_and_quick_ones_do_not() {
    let mut rig = noisy();
    let (round, phase_rad) = (1e-5, 0.0);
    let round = Effect::Eccentricity {
        amplitude_rad: round,
        phase_rad,
    };
    let distances = |rig: &Rig| {
        let ideal = Ideal::new(std::slice::from_ref(rig));
        (ideal.distance(&round), ideal.distance(&WIDTH))
    };
    let (slow, quick) = distances(&rig);
    rig.noise_psd = 2.0 * rig.damping(true) * (1e-3 * 10.0 * rig.inertia).powi(2);
    let (slow_hidden, quick_hidden) = distances(&rig);
    assert!(slow_hidden < 0.1 * slow, "{slow_hidden} {slow}");
    assert!(quick_hidden > 0.95 * quick, "{quick_hidden} {quick}");
}

#[test]
fn an_unknown_disc_takes_what_repeats_and_leaves_what_two_speeds_tell_apart() {
    let rig = Rig {
        disc_known: false,
        ..noisy()
    };
    let alone = Ideal::new(std::slice::from_ref(&rig)).distance(&WIDTH);
    assert!(alone < 1e-3, "{alone}");
    let fast = Rig {
        profile: Profile::Constant { speed: 30.0 },
        ..rig.clone()
    };
    let rigs = [rig.clone(), fast];
    let late = 1e-7;
    let delay = Effect::EdgeDelay {
        rise_s: [late; 3],
        fall_s: [0.0; 3],
    };
    // Half the delay times the speed on either side, on noise that grows with the speed; the common pattern takes its best.
    let distance = Ideal::new(&rigs).distance(&delay);
    let expected = 0.5 * late * (30.0 - 10.0) / (10.0_f64.powi(2) + 30.0_f64.powi(2)).sqrt()
        * edges(&rig).sqrt()
        / rig.stamp_rms_s();
    assert!(
        (distance / expected - 1.0).abs() < 0.01,
        "{distance} {expected}"
    );
}

#[test]
fn excess_jitter_is_found_as_a_variance_is() {
    let rig = noisy();
    let jitter_s = 1e-7;
    let distance =
        Ideal::new(std::slice::from_ref(&rig)).distance(&Effect::TimestampJitter { jitter_s });
    let expected = (0.5 * edges(&rig)).sqrt() * (jitter_s / rig.stamp_rms_s()).powi(2);
    assert!(
        (distance / expected - 1.0).abs() < 0.01,
        "{distance} {expected}"
    );
}

#[test]
fn one_speed_does_not_tell_a_width_from_a_delay_and_two_do() {
    let rig = noisy();
    let fast = Rig {
        profile: Profile::Constant { speed: 30.0 },
        ..rig.clone()
    };
    let rigs = [rig, fast];
    let one = Ideal::new(&rigs[..1]);
    let (distance, apart) = (one.distance(&WIDTH), one.separation(&WIDTH).unwrap());
    assert!(apart < 1e-3 * distance, "{apart} {distance}");
    let two = Ideal::new(&rigs);
    let (distance, apart) = (two.distance(&WIDTH), two.separation(&WIDTH).unwrap());
    // Lengths of the signal at speeds v and 3 v, in the noise there, are as 3 to 1; a delay has 1 to 1 and explains four fifths of
    // the square.
    let expected = (1.0_f64 - 0.8).sqrt();
    assert!(
        (apart / distance / expected - 1.0).abs() < 0.01,
        "{apart} {distance}"
    );
}

#[test]
fn nobody_tells_a_friction_better_than_torque_noise_lets_them() {
    let mut rig = noisy();
    rig.stiffness = 0.0;
    rig.profile = Profile::RunDown {
        speed: 10.0,
        off_s: 0.5,
    };
    rig.viscous = 0.1 * rig.inertia;
    rig.noise_psd = 1e-5 * rig.inertia * rig.inertia;
    let ripple = Order {
        order: 6.0,
        phase_rad: 0.3,
        torque_n_m: 20.0 * rig.inertia,
    };
    rig.ripples = vec![ripple];
    let coulomb_n_m = 1e-3 * rig.inertia;
    let friction = Effect::Friction {
        coulomb_n_m,
        viscous_n_m_s: 0.0,
        drag_n_m_s2: 0.0,
        stribeck_n_m: 0.0,
        stribeck_rad_s: 1.0,
    };
    let rigs = [rig];
    let ideal = Ideal::of(&rigs, &friction);
    let distance = ideal.distance(&friction);
    let larger = ideal.distance(&friction.scaled(20.0));
    assert!((larger / distance / 20.0 - 1.0).abs() < 0.05, "{larger}");
    // A constant deceleration in white acceleration noise: its square over the density, for as long as it lasts.
    let seconds = turn_evenly(&rigs[0], &[])
        .crossings
        .last()
        .map_or(0.0, |last| last.time_s);
    let bound = 1e-3 * ((seconds - 0.5) / 1e-5).sqrt();
    assert!(
        distance < 1.01 * bound && distance > 0.2 * bound,
        "{distance} of {bound} in {seconds} s"
    );
}

#[test]
fn a_drift_that_ends_a_run_sooner_has_no_end_in_it() {
    let mut rig = noisy();
    rig.noise_psd = 0.2 * rig.inertia * rig.inertia;
    let drift = Effect::SpeedDrift {
        fraction_per_s: 1e-2,
    };
    let rigs = [rig];
    let ideal = Ideal::of(&rigs, &drift);
    let white = ideal.residual(&drift);
    let tenths: Vec<f64> = white
        .chunks(white.len() / 10)
        .map(|part| part.iter().map(|w| w * w).sum())
        .collect();
    // A torque that grows evenly, less its mean and trend, is largest at both ends.
    assert!(
        tenths[9] < 1.5 * tenths[0] && tenths[9] > 0.5 * tenths[0],
        "{tenths:?}"
    );
}
