//! Twins with findings in them can be run.

use nalgebra::DMatrix;

use super::*;
use crate::diagnose::hypothesis::Hypothesis;
use crate::mechanism::Mechanism;

fn with(basis: Basis, size: f64) -> Twin {
    let text = "duration = { turns = 5 }\n[encoder.quadrature]\nlines = 50\n[shaft]\ninertia_kg_m2 = 1e-4\n\
                [drive.constant]\nr_min = 240\n[timer]\nclock_hz = 84000000\n";
    let mut mended = Mended {
        twin: Twin::parse(text, "rig").unwrap(),
        errors_rad: Vec::new(),
        edges: 200,
        classes: 4,
    };
    let estimate = Estimate {
        hypothesis: Hypothesis::of(Mechanism::Unknown, basis),
        sizes: vec![size],
        searched: Vec::new(),
        covariance: DMatrix::zeros(1, 1),
        between: Default::default(),
    };
    mended.add(&estimate, 0, 1);
    mended.twin.check().unwrap();
    mended.twin
}

#[test]
fn delays_of_two_channels_leave_the_third_alone() {
    for size in [3e-7, -3e-7] {
        let delay = with(Basis::RiseLate { channel: None }, size)
            .edge_delay
            .unwrap();
        for one in [delay.a, delay.b] {
            assert!((one.rise_s - one.fall_s - size).abs() < 1e-15);
        }
        let skew = with(Basis::Late { channel: 1 }, size).channel_skew.unwrap();
        assert!((skew.b_s - skew.a_s - size).abs() < 1e-15);
    }
}

#[test]
fn rises_of_one_channel_ahead_leave_its_falls_and_the_other_channel_where_they_are() {
    for channel in [0, 1] {
        let earlier = with(
            Basis::RiseLate {
                channel: Some(channel),
            },
            -3e-7,
        );
        let delay = earlier.edge_delay.unwrap();
        let all = [delay.a, delay.b];
        let (own, other) = (all[channel], all[1 - channel]);
        assert_eq!(own.rise_s, 0.0);
        for waits in [own.fall_s, other.rise_s, other.fall_s] {
            assert!((waits - own.rise_s - 3e-7).abs() < 1e-15);
        }
    }
}
