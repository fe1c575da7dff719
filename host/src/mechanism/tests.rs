use std::collections::BTreeSet;

use super::*;
use crate::diagnose::basis::Basis;
use crate::diagnose::estimate::Estimate;
use crate::diagnose::hypothesis::Hypothesis;
use crate::diagnose::mended::Mended;
use crate::diagnose::named::{implausible, parameters};
use crate::twin::Twin;

/// Every kind of pattern, and whose it is.
const PATTERNS: [(Basis, Mechanism); 22] = [
    (Basis::Round { order: 1.0 }, Mechanism::Eccentricity),
    (Basis::Round { order: 2.0 }, Mechanism::DiscTilt),
    (Basis::Round { order: 17.0 }, Mechanism::LineError),
    (Basis::Lagged { order: 3.57 }, Mechanism::Bearing),
    (Basis::Lagged { order: 1.0 }, Mechanism::Eccentricity),
    (Basis::TorqueOrder { order: 2.0 }, Mechanism::TorqueRipple),
    (Basis::TorqueOrder { order: 7.3 }, Mechanism::GearMesh),
    (Basis::TorqueTone { f_hz: 50.0 }, Mechanism::TorqueTone),
    (
        Basis::LevelTone {
            f_hz: 100.0,
            channel: Some(1),
        },
        Mechanism::ThresholdRipple,
    ),
    (Basis::Width { channel: Some(1) }, Mechanism::WidthError),
    (Basis::Shift { channel: 1 }, Mechanism::QuadratureError),
    (Basis::RiseLate { channel: Some(0) }, Mechanism::EdgeDelay),
    (Basis::FallEarly { channel: 1 }, Mechanism::EdgeDelay),
    (Basis::Late { channel: 1 }, Mechanism::ChannelSkew),
    (
        Basis::LevelDrift {
            from_s: 0.5,
            tau_s: 2.0,
            channel: Some(0),
        },
        Mechanism::ThresholdDrift,
    ),
    (
        Basis::Bump {
            angle_rad: 1.0,
            width_rad: 0.1,
            channel: None,
            rises: Some(true),
        },
        Mechanism::LocalDefect,
    ),
    (
        Basis::Load {
            from_s: 0.1,
            until_s: 0.2,
        },
        Mechanism::LoadStep,
    ),
    (Basis::Drift, Mechanism::SpeedDrift),
    (Basis::Viscous, Mechanism::Friction),
    (Basis::Drag, Mechanism::Friction),
    (Basis::Stribeck { rad_s: 3.0 }, Mechanism::Friction),
    (Basis::Direction, Mechanism::Hysteresis),
];

fn rig() -> Twin {
    let text = "duration = { turns = 4 }\n[encoder.quadrature]\nlines = 100\n[shaft]\ninertia_kg_m2 = 1e-4\n\
                [drive.constant]\nr_min = 100.0\n[timer]\nclock_hz = 84000000\n";
    Twin::parse(text, "rig").unwrap()
}

fn unmended() -> Mended {
    Mended {
        twin: rig(),
        errors_rad: Vec::new(),
        edges: 400,
        classes: 4,
    }
}

fn estimate(basis: Basis, size: f64) -> Estimate {
    Estimate {
        hypothesis: Hypothesis::by(basis),
        sizes: vec![size; basis.count()],
        searched: Vec::new(),
        covariance: nalgebra::DMatrix::identity(basis.count(), basis.count()),
        between: Default::default(),
    }
}

#[test]
fn ids_are_what_serde_writes_and_each_is_its_own() {
    let mut seen = BTreeSet::new();
    for mechanism in Mechanism::ALL {
        let written = serde_json::to_string(&mechanism).unwrap();
        assert_eq!(written, format!("\"{}\"", mechanism.id()));
        assert_eq!(
            serde_json::from_str::<Mechanism>(&written).unwrap(),
            mechanism
        );
        assert_eq!(Mechanism::from_id(mechanism.id()), Some(mechanism));
        assert_eq!(mechanism.to_string(), mechanism.id());
        assert!(seen.insert(mechanism.id()));
    }
    assert_eq!(seen.len(), 28);
    assert_eq!(Mechanism::from_id("gremlins"), None);
}

#[test]
fn look_alikes_go_both_ways_and_none_is_alike_to_itself() {
    for one in Mechanism::ALL {
        for other in one.look_alikes() {
            assert_ne!(one, *other);
            assert!(other.look_alikes().contains(&one), "{one} and {other}");
        }
        assert_eq!(one.look_alikes().is_empty(), one == Mechanism::Unknown);
        let card = one.card();
        for other in card.same_mark.iter().chain(card.told_by_rig) {
            assert!(one.look_alikes().contains(other), "{one} and {other}");
        }
        for other in card.same_mark {
            assert!(other.card().same_mark.contains(&one), "{one} and {other}");
        }
    }
}

#[test]
fn torque_of_an_order_falls_with_the_square_of_the_speed_and_delays_grow_with_it() {
    let exponent = |mechanism: Mechanism| mechanism.card().speed_exponent;
    assert_eq!(exponent(Mechanism::TorqueRipple), Some(-2));
    assert_eq!(exponent(Mechanism::EdgeDelay), Some(1));
    assert_eq!(exponent(Mechanism::Eccentricity), Some(0));
    assert_eq!(exponent(Mechanism::Bearing), None);
}

#[test]
fn each_says_what_it_keeps_step_with_and_which_recording_decides() {
    for mechanism in Mechanism::ALL {
        let known = mechanism != Mechanism::Unknown;
        let card = mechanism.card();
        assert_eq!(!card.locked_to.is_empty(), known, "{mechanism}");
        assert!(mechanism.separated_by().ends_with('.'));
        assert!(!mechanism.title().ends_with('.'));
        assert!(card.physics.ends_with('.'), "{mechanism}");
    }
}

#[test]
fn the_documentation_of_each_file_has_the_equation_and_the_source_of_its_card() {
    let folder = concat!(env!("CARGO_MANIFEST_DIR"), "/src/mechanism");
    let plain = |text: &str| text.split_whitespace().collect::<Vec<_>>().join(" ");
    for mechanism in Mechanism::ALL {
        let text = std::fs::read_to_string(format!("{folder}/{mechanism}.rs")).unwrap();
        let lines = text.lines().filter_map(|line| line.strip_prefix("//!"));
        let doc = plain(&lines.collect::<Vec<_>>().join(" "));
        let card = mechanism.card();
        assert!(doc.starts_with(&format!("`{mechanism}`: ")), "{doc}");
        assert!(
            doc.contains(&plain(card.equation)),
            "{mechanism}: {}",
            card.equation
        );
        let source = format!("Source: {}", plain(card.source));
        assert!(doc.contains(&source), "{mechanism}: {source}");
    }
}

#[test]
fn every_section_is_one_that_a_twin_may_have() {
    let keys: Vec<String> = include_str!("../../twins/keys.txt")
        .lines()
        .filter_map(|line| Some(line.split_whitespace().next()?.replace("[]", "")))
        .collect();
    for mechanism in Mechanism::ALL {
        let twin = mechanism.card().twin;
        let known = mechanism != Mechanism::Unknown;
        let there = |key: &String| key == twin || key.starts_with(&format!("{twin}."));
        assert_eq!(keys.iter().any(there), known, "{mechanism}: {twin}");
    }
}

#[test]
fn ranges_hold_numbers_and_units_are_those_of_the_names() {
    for mechanism in Mechanism::ALL {
        for one in mechanism.card().parameters {
            let middle = 0.5 * (one.from + one.to);
            assert!(one.from < one.to && one.allows(middle), "{one:?}");
            assert!(!one.allows(f64::NAN) && !one.allows(2.0 * one.to));
            let end = match one.unit {
                "1" => "",
                "1/s" => "per_s",
                "N m" => "n_m",
                "N m s" => "n_m_s",
                "N m s^2" => "n_m_s2",
                "N^2 m^2 s" => "n2_m2_s",
                "N m/rad" => "n_m_rad",
                "rad/s" => "rad_s",
                "Hz" => "hz",
                unit => unit,
            };
            assert!(one.name.ends_with(end), "{one:?}");
        }
    }
}

#[test]
fn every_pattern_is_of_one_mechanism_that_names_its_numbers_and_puts_it_into_a_twin() {
    for (basis, mechanism) in PATTERNS {
        assert_eq!(basis.mechanism(), mechanism);
        let makers = Mechanism::ALL
            .into_iter()
            .filter(|one| (one.card().handling.makes)(basis));
        assert_eq!(makers.count(), 1, "{basis:?}");
        let named = parameters(&estimate(basis, 0.01));
        assert!(!named.is_empty(), "{basis:?}");
        for (name, parameter) in named {
            let quantity = mechanism.card().quantity(&name);
            let quantity = quantity.unwrap_or_else(|| panic!("{mechanism}: {name}"));
            assert_eq!(parameter.unit, quantity.unit);
            assert!(quantity.allows(parameter.value), "{name} {parameter:?}");
        }
        if matches!(basis, Basis::Lagged { order } if order.fract() == 0.0) {
            continue;
        }
        let mut mended = unmended();
        mended.add(&estimate(basis, 0.001), 0, 1);
        assert!(mended.twin != rig() || !mended.errors_rad.is_empty());
        mended.twin.check().unwrap();
    }
}

#[test]
fn delays_are_those_of_channels_that_the_encoder_has() {
    let late = [
        (Basis::RiseLate { channel: None }, 2e-6),
        (Basis::RiseLate { channel: None }, -2e-6),
        (Basis::FallEarly { channel: 1 }, 2e-6),
        (Basis::FallEarly { channel: 1 }, -2e-6),
        (Basis::Late { channel: 1 }, 2e-6),
        (Basis::Late { channel: 1 }, -2e-6),
    ];
    for (basis, size) in late {
        let mut mended = unmended();
        mended.add(&estimate(basis, size), 0, 1);
        mended.twin.check().unwrap();
        let [rise_less_fall, skew] = [
            mended
                .twin
                .edge_delay
                .map_or(0.0, |delay| delay.b.rise_s - delay.b.fall_s),
            mended
                .twin
                .channel_skew
                .map_or(0.0, |skew| skew.b_s - skew.a_s),
        ];
        assert_eq!(rise_less_fall + skew, size, "{basis:?}");
    }
}

#[test]
fn a_fit_with_a_number_that_no_rig_has_is_told() {
    let (quantity, value) = implausible(&estimate(Basis::Drift, 50.0)).unwrap();
    assert_eq!((quantity.name, value), ("fraction_per_s", 50.0));
    assert!(implausible(&estimate(Basis::Drift, 0.05)).is_none());
    let eccentric = |size: f64| implausible(&estimate(Basis::Round { order: 1.0 }, size));
    assert!(eccentric(0.05).is_none() && eccentric(0.08).is_some());
    assert!(implausible(&estimate(Basis::Shift { channel: 1 }, f64::NAN)).is_some());
}
