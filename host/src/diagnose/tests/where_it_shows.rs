//! A delay is told on the channel and the edges that are late, whatever the sensor.

use super::super::run::diagnose;
use super::{recorded, twin};
use crate::mechanism::Mechanism;
use crate::twin::{EdgeDelay, RiseFall, Twin};

const LATE_S: f64 = 40e-6;

fn rig(encoder: &str, seed: u32, r_min: f64) -> Twin {
    twin(&format!(
        "duration = {{ turns = 20 }}\nseed = {seed}\n{encoder}\n[shaft]\ninertia_kg_m2 = 1e-4\n\
         viscous_n_m_s = 2e-4\nstiffness_n_m_s = 4e-4\n[drive.constant]\nr_min = {r_min}\n\
         [noise.white]\npsd_n2_m2_s = 1e-12\n[timer]\nclock_hz = 84000000\njitter_s = 1e-6\n"
    ))
}

/// Where a mechanism is said to show: channels and edges.
type Said = (Vec<String>, Vec<String>);

/// What is said of edges that come late on a channel, by two recordings at two speeds.
fn said(encoder: &str, channel: usize, [rise_s, fall_s]: [f64; 2]) -> Vec<(Mechanism, Said)> {
    let mut delay = EdgeDelay::default();
    [&mut delay.a, &mut delay.b, &mut delay.c]
        .into_iter()
        .nth(channel)
        .into_iter()
        .for_each(|one| *one = RiseFall { rise_s, fall_s });
    let recordings = [(5, 240.0), (6, 600.0)].map(|(seed, r_min)| {
        let told = rig(encoder, seed, r_min);
        let mut truth = told.clone();
        truth.edge_delay = Some(delay);
        recorded(&truth, &told)
    });
    let found = diagnose(&recordings, &mut |_, _| {}).unwrap();
    let each = found.diagnosis.findings.into_iter();
    each.map(|finding| {
        let place = finding.place;
        if matches!(
            finding.mechanism,
            Mechanism::EdgeDelay | Mechanism::ChannelSkew
        ) {
            assert_eq!(place.speed_exponent, Some(1.0), "{}", finding.text);
        }
        (finding.mechanism, (place.channels, place.edge_classes))
    })
    .collect()
}

fn words(all: &[&str]) -> Vec<String> {
    all.iter().map(|one| (*one).to_owned()).collect()
}

#[test]
fn a_delay_is_told_on_its_channel_and_its_edges() {
    let sensors: [(&str, &[&str]); 3] = [
        (
            "[encoder.quadrature]\nlines = 60\nindex = false",
            &["A", "B"],
        ),
        ("[encoder.hall]\npole_pairs = 8", &["A", "B", "C"]),
        ("[encoder.wheel]\nteeth = 40", &["A"]),
    ];
    for (encoder, channels) in sensors {
        for (number, channel) in channels.iter().enumerate() {
            let edge = |rises: bool| {
                let edge = if rises { "rise" } else { "fall" };
                match channels {
                    [_] => edge.to_owned(),
                    _ => format!("{channel} {edge}"),
                }
            };
            let own = words(&[channel]);
            let both = |mut said: Said| {
                said.1.sort();
                said
            };
            // Late falls of another channel than A are fitted as several mechanisms: no one of them has a place to be held to.
            let kinds = if number == 0 {
                vec![true, false]
            } else {
                vec![true]
            };
            for rises in kinds {
                let delays = if rises { [LATE_S, 0.0] } else { [0.0, LATE_S] };
                let all = said(encoder, number, delays);
                let delay = all.iter().find(|(one, _)| *one == Mechanism::EdgeDelay);
                assert_eq!(
                    delay.map(|(_, said)| said.clone()),
                    Some((own.clone(), vec![edge(rises)])),
                    "{encoder} {delays:?}: {all:?}"
                );
            }
            if channels.len() > 1 {
                let all = said(encoder, number, [LATE_S; 2]);
                let skew = all.iter().find(|(one, _)| *one == Mechanism::ChannelSkew);
                assert_eq!(
                    skew.map(|(_, said)| both(said.clone())),
                    Some((own, vec![edge(false), edge(true)])),
                    "{encoder}: {all:?}"
                );
            }
        }
    }
}
