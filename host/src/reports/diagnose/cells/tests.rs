use std::collections::BTreeMap;

use std::f64::consts::TAU;

use super::*;
use crate::diagnose::diagnosis::AtSpeed;
use crate::effect::On;

const HALF_TURN: f64 = 0.5 * TAU;

fn on(channel: Option<u8>, rises: Option<bool>) -> On {
    On { channel, rises }
}

fn sites() -> Vec<(Site, &'static str)> {
    vec![
        (Site::Torque, "torque"),
        (Site::Drive, "drive speed"),
        (Site::Disc(On::ALL), "angle of all edges"),
        (
            Site::Disc(on(Some(1), None)),
            "angle of the edges of channel B",
        ),
        (
            Site::Disc(on(Some(0), Some(false))),
            "angle of falling edges of channel A",
        ),
        (Site::Level(On::ALL), "comparator level"),
        (
            Site::Level(on(Some(2), None)),
            "comparator level of channel C",
        ),
        (Site::Stamp(On::ALL), "delay of all edges"),
        (Site::Stamp(on(None, Some(true))), "delay of rising edges"),
        (
            Site::Stamp(on(Some(1), None)),
            "delay of the edges of channel B",
        ),
    ]
}

/// Each carrier with the words after the site, as it is and with a growth.
fn carriers() -> Vec<(Carrier, &'static str, bool)> {
    let endless = f64::INFINITY;
    vec![
        (Carrier::Steady, "", true),
        (Carrier::Order(3.0), " at order 3", true),
        (Carrier::Order(3.217), " at order 3.217", true),
        (Carrier::Tone(41.3), " at 41.3 Hz", true),
        (
            Carrier::Chirp(41.3, -0.25),
            " at 41.3 Hz at time 0, falling by 250 mHz a second",
            true,
        ),
        (
            Carrier::Chirp(41.3, 2.0),
            " at 41.3 Hz at time 0, rising by 2 Hz a second",
            true,
        ),
        (
            Carrier::Bump(-HALF_TURN / 2.0, HALF_TURN / 180.0),
            " around 270 degrees, with a sigma of 1 degrees",
            true,
        ),
        (
            Carrier::Window(1.5, 3.25),
            " from 1.5 s until 3.25 s",
            false,
        ),
        (Carrier::Window(1.5, endless), " from 1.5 s on", false),
        (Carrier::Window(-endless, 3.25), " until 3.25 s", false),
        (Carrier::Window(-endless, endless), " all the time", false),
        (
            Carrier::Settling(0.0, 12.5),
            " from 0 s on, settling with a time constant of 12.5 s",
            false,
        ),
        (Carrier::Time, " in proportion to time", false),
        (Carrier::Direction, " by the direction of motion", false),
        (
            Carrier::Power(0.0),
            " against the motion, the same at every speed (Coulomb)",
            false,
        ),
        (
            Carrier::Power(1.0),
            " against the motion, proportional to speed (viscous)",
            false,
        ),
        (
            Carrier::Power(2.0),
            " against the motion, proportional to the square of the speed",
            false,
        ),
        (
            Carrier::Power(1.5),
            " against the motion, with the power 1.5 of the speed",
            false,
        ),
        (
            Carrier::Stribeck(3.1),
            " against the motion, fading above 3.1 rad/s (Stribeck)",
            false,
        ),
    ]
}

fn growths() -> Vec<(Growth, &'static str)> {
    vec![
        (Growth::Even(0.03), " grows by 3 % a second"),
        (Growth::Even(-0.005), " falls by 0.5 % a second"),
        (Growth::Speed(0.0), " the same at every speed"),
        (Growth::Speed(1.0), " proportional to speed"),
        (
            Growth::Speed(2.0),
            " proportional to the square of the speed",
        ),
        (
            Growth::Speed(-1.5),
            " with the power \u{2212}1.5 of the speed",
        ),
        (
            Growth::Modulated(2.1, 0.3, 0.4),
            " swings by 30 % at 2.1 Hz",
        ),
    ]
}

#[test]
fn every_site_carrier_and_growth_has_its_words() {
    for (site, of_site) in sites() {
        for (carrier, of_carrier, says_constant) in carriers() {
            let constant = Effect::new(site, carrier);
            let end = if says_constant { ", constant" } else { "" };
            assert_eq!(words(&constant), format!("{of_site}{of_carrier}{end}"));
            let noun = match constant.sizes() {
                2 => "amplitude",
                _ => "size",
            };
            for (growth, of_growth) in growths() {
                let effect = Effect { growth, ..constant };
                let expected = format!("{of_site}{of_carrier}, its {noun}{of_growth}");
                assert_eq!(words(&effect), expected);
            }
        }
    }
}

#[test]
fn no_two_cells_share_their_words_and_none_is_long() {
    let mut seen = BTreeMap::new();
    for (site, _) in sites() {
        for (carrier, ..) in carriers() {
            let constant = (Growth::Constant, "");
            for (growth, _) in growths().into_iter().chain([constant]) {
                let effect = Effect {
                    site,
                    carrier,
                    growth,
                    only: None,
                };
                let text = words(&effect);
                assert!(text.split_whitespace().count() < 30, "{text}");
                let other = seen.insert(text.clone(), effect);
                assert!(other.is_none(), "{text}: {effect:?} and {other:?}");
            }
        }
    }
}

#[test]
fn the_unit_is_that_of_the_site_over_what_carrier_and_growth_bring() {
    let growing = |site, carrier, growth| Effect {
        growth,
        ..Effect::new(site, carrier)
    };
    for (effect, expected) in [
        (Effect::new(Site::Torque, Carrier::Order(3.0)), "N m"),
        (Effect::new(Site::Torque, Carrier::Power(1.0)), "N m s/rad"),
        (
            Effect::new(Site::Torque, Carrier::Power(2.0)),
            "N m (s/rad)^2",
        ),
        (Effect::new(Site::Drive, Carrier::Time), "1/s"),
        (Effect::new(Site::Stamp(On::ALL), Carrier::Steady), "s"),
        (
            growing(Site::Disc(On::ALL), Carrier::Steady, Growth::Speed(1.0)),
            "rad s/rad",
        ),
        (
            growing(Site::Torque, Carrier::Power(1.0), Growth::Speed(-1.0)),
            "N m",
        ),
    ] {
        assert_eq!(unit(&effect, true), expected, "{effect:?}");
    }
}

#[test]
fn the_size_of_a_phase_is_its_amplitude_with_a_prefix_only_before_plain_units() {
    let sized = |carrier, sizes: &[f64]| Sized {
        effect: Effect::new(Site::Torque, carrier),
        sizes: sizes.to_vec(),
        ci95: Vec::new(),
        at_speed: None,
    };
    let all = [
        sized(Carrier::Order(3.0), &[3e-3, 4e-3]),
        sized(Carrier::Power(1.0), &[2e-3]),
    ];
    assert_eq!(
        sizes(&all, true),
        ["amplitude 5.00 mN m", "size 0.002 N m s/rad"]
    );
    let sweep = Sized {
        ci95: vec![
            Some([4.9e-3, 5.1e-3]),
            Some([41.18, 41.42]),
            Some([-0.26, -0.24]),
        ],
        ..sized(Carrier::Chirp(41.3, -0.25), &[3e-3, 4e-3])
    };
    assert_eq!(
        sizes(&[sweep], true),
        [
            "amplitude 5.00 ± 0.10 mN m, frequency at time 0 41.30 ± 0.12 Hz, sweep \u{2212}250 ± 10 mHz/s"
        ]
    );
    // What goes with a power of the speed has a plain unit at one speed, and an interval that says how well it is known there.
    let grown = Sized {
        effect: Effect {
            growth: Growth::Speed(2.5),
            ..Effect::new(Site::Disc(On::ALL), Carrier::Steady)
        },
        sizes: vec![2e-9],
        ci95: vec![Some([-4e-9, 8e-9]), Some([2.0, 3.0])],
        at_speed: Some(AtSpeed {
            rad_s: 100.0,
            size: 2e-4,
            ci95: [1.9e-4, 2.1e-4],
        }),
    };
    assert_eq!(
        sizes(&[grown], true),
        ["size 200 ± 10 µrad at 954.9 r/min, power of the speed 2.50 ± 0.50"]
    );
    // Without an inertia no torque is known, and no motor is said to have thousands of N m.
    assert_eq!(
        sizes(&all, false),
        [
            "amplitude 0.005 N m/(kg m^2)",
            "size 0.002 N m/(kg m^2) s/rad"
        ]
    );
    assert_eq!(
        cell(&all),
        "torque at order 3, constant; torque against the motion, proportional to speed (viscous)"
    );
    let many = vec![all[1].clone(); 6];
    assert!(cell(&many).ends_with("; 2 more"));
}

#[test]
fn an_order_and_its_harmonics_are_one_clause() {
    let sized = |order: f64| Sized {
        effect: Effect::new(Site::Torque, Carrier::Order(order)),
        sizes: vec![3e-3, 4e-3],
        ci95: Vec::new(),
        at_speed: None,
    };
    assert_eq!(
        cell(&[3.0, 6.0, 9.0].map(sized)),
        "torque at orders 3, 6, 9, constant"
    );
}

#[test]
fn a_place_is_one_of_the_first_turn() {
    let around = |angle: f64| Sized {
        effect: Effect::new(Site::Disc(On::ALL), Carrier::Bump(angle, 0.5)),
        sizes: vec![1e-3],
        ci95: vec![None, Some([angle - 0.1, angle + 0.1]), None],
        at_speed: None,
    };
    for angle in [0.89, 0.89 + TAU, 0.89 - TAU] {
        assert_eq!(
            sizes(&[around(angle)], true),
            ["size 1.00 mrad, place 890 ± 100 mrad"]
        );
    }
}

#[test]
fn a_width_that_was_held_has_no_interval() {
    let held = Sized {
        effect: Effect::new(Site::Disc(On::ALL), Carrier::Bump(0.89, 0.5)),
        sizes: vec![1e-3],
        ci95: vec![None, Some([0.79, 0.99]), Some([0.5, 0.5])],
        at_speed: None,
    };
    // Once "width (sigma) 500 mrad, 500 mrad to 500 mrad".
    assert_eq!(
        sizes(&[held], true),
        ["size 1.00 mrad, place 890 ± 100 mrad"]
    );
}
