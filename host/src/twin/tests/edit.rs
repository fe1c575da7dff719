use std::path::PathBuf;

use proptest::prelude::*;
use proptest::sample::subsequence;

use super::*;

fn examples() -> Vec<(String, String)> {
    let folder = concat!(env!("CARGO_MANIFEST_DIR"), "/twins");
    let files = std::fs::read_dir(folder)
        .unwrap()
        .map(|file| file.unwrap().path());
    let twins = files.filter(|path| path.extension().is_some_and(|end| end == "toml"));
    let mut all: Vec<(String, String)> = twins
        .map(|path| {
            (
                path.display().to_string(),
                std::fs::read_to_string(&path).unwrap(),
            )
        })
        .collect();
    all.sort();
    all
}

/// Lines of the new text that the old one does not have, and the other way round.
fn difference(old: &str, new: &str) -> (Vec<String>, Vec<String>) {
    let without = |a: &str, b: &str| {
        let mut left: Vec<&str> = b.lines().collect();
        let mut lines = Vec::new();
        for line in a.lines().filter(|line| !line.is_empty()) {
            match left.iter().position(|other| *other == line) {
                Some(at) => _ = left.remove(at),
                None => lines.push(line.to_owned()),
            }
        }
        lines
    };
    (without(new, old), without(old, new))
}

/// The changed text, which reads back as the changed twin.
fn changed(text: &str, name: &str, change: impl Fn(&mut Twin)) -> String {
    let old = Twin::parse(text, name).unwrap();
    let mut new = old.clone();
    change(&mut new);
    let text = edited(text, &old, &new).unwrap();
    let back = Twin::parse(&text, name).unwrap_or_else(|e| panic!("{e}\n{text}"));
    assert_eq!(back, new, "{text}");
    text
}

const RIG: &str = "\
# My rig.
seed = 1
duration = { turns = 12 } # twelve

[timer] # the timer first
clock_hz = 84e6

# The encoder.
[encoder.quadrature]
lines = 2_500 # printed on it
index = true

[shaft]
inertia_kg_m2 = 1e-4  # from the data sheet

[[ripple]] # cogging
order = 5
torque_n_m = 1e-3

[drive.constant]
r_min = 15
";

#[test]
fn without_a_change_the_text_stays_as_it_is() {
    for (name, text) in examples() {
        assert_eq!(changed(&text, &name, |_| ()), text, "{name}");
    }
    assert_eq!(changed(RIG, "rig.toml", |_| ()), RIG);
}

#[test]
fn a_value_is_changed_in_its_place_and_its_comment_stays() {
    let text = changed(RIG, "rig.toml", |twin| {
        twin.shaft.inertia_kg_m2 = 2e-4;
        twin.duration = Duration::Turns(3.0);
    });
    let expected = RIG
        .replace("1e-4  #", "0.0002  #")
        .replace("turns = 12 }", "turns = 3.0 }");
    assert_eq!(text, expected);
}

#[test]
fn what_is_new_comes_at_the_end_and_new_keys_at_the_end_of_their_section() {
    let text = changed(RIG, "rig.toml", |twin| {
        twin.shaft.viscous_n_m_s = 1e-5;
        twin.errors.width_a_rad = 1e-4;
        twin.errors.eccentricity = Some(Harmonic {
            amplitude_rad: 1e-3,
            phase_rad: 0.5,
        });
        twin.torque_tone = vec![TorqueTone {
            f_hz: 50.0,
            phase_rad: 0.0,
            torque_n_m: Some(1e-3),
            speed_fraction: None,
        }];
    });
    let expected = RIG.replace(
        "# from the data sheet\n",
        "# from the data sheet\nviscous_n_m_s = 0.00001\n",
    ) + "
[errors]
width_a_rad = 0.0001

[errors.eccentricity]
amplitude_rad = 0.001
phase_rad = 0.5

[[torque_tone]]
f_hz = 50.0
phase_rad = 0.0
torque_n_m = 0.001
";
    assert_eq!(text, expected);
}

#[test]
fn entries_of_a_list_come_and_go_beside_the_others() {
    let entry = |order| Ripple {
        order,
        phase_rad: 0.0,
        torque_n_m: Some(1e-3),
        speed_fraction: None,
    };
    let text = changed(RIG, "rig.toml", |twin| {
        twin.ripple.insert(0, entry(1.0));
        twin.ripple.push(entry(10.0));
    });
    let (more, less) = difference(RIG, &text);
    assert!(less.is_empty(), "{less:?}\n{text}");
    assert_eq!(more.iter().filter(|line| *line == "[[ripple]]").count(), 2);
    let back = changed(&text, "rig.toml", |twin| {
        twin.ripple.remove(0);
        twin.ripple.pop();
    });
    assert_eq!(back, RIG);
    let none = changed(RIG, "rig.toml", |twin| twin.ripple.clear());
    let (more, less) = difference(RIG, &none);
    assert!(more.is_empty(), "{more:?}");
    assert_eq!(
        less,
        ["[[ripple]] # cogging", "order = 5", "torque_n_m = 1e-3"]
    );
}

#[test]
fn a_drive_of_another_kind_takes_the_place_of_the_old() {
    let text = changed(RIG, "rig.toml", |twin| {
        twin.drive = Drive::Steps(vec![
            Step {
                t_s: 0.0,
                r_min: 10.0,
            },
            Step {
                t_s: 1.0,
                r_min: 20.0,
            },
        ]);
    });
    let (_, less) = difference(RIG, &text);
    assert_eq!(less, ["[drive.constant]", "r_min = 15"], "{text}");
}

#[test]
fn dotted_keys_inline_tables_and_empty_lists_take_values() {
    let text = "duration.turns = 2 # dotted\nripple = []\nbearing = [{ order = 1.5, runout_rad = 1e-4 }] # one\n\
                encoder = { quadrature = { lines = 10, index = true } }\ntimer.clock_hz = 1e6\n\
                shaft = { inertia_kg_m2 = 1 }\ndrive.constant.r_min = 60\n";
    let new = changed(text, "rig.toml", |twin| {
        twin.duration = Duration::Seconds(3.0);
        twin.bearing.push(Bearing {
            order: 2.5,
            ..twin.bearing[0]
        });
        twin.ripple = vec![Ripple {
            order: 2.0,
            phase_rad: 0.0,
            torque_n_m: Some(1.0),
            speed_fraction: None,
        }];
        twin.timer.jitter_s = 1e-8;
        twin.shaft.coulomb_n_m = 1e-3;
        twin.errors.tilt = Some(Harmonic {
            amplitude_rad: 1e-3,
            phase_rad: 0.0,
        });
        twin.encoder = Encoder::Hall { pole_pairs: 2 };
        twin.seed = 5;
    });
    assert!(
        new.contains("# one") && new.contains("timer.jitter_s = "),
        "{new}"
    );
}

type Change = (&'static str, fn(&mut Twin));

const CHANGES: &[Change] = &[
    ("seed", |t| t.seed += 7),
    ("duration", |t| t.duration = Duration::Seconds(0.75)),
    ("position", |t| {
        t.errors.list_rad = Vec::new();
        t.errors.position = Some(Position::Normal {
            rms_rad: 1e-5,
            per: Per::Line,
        });
    }),
    ("errors", |t| t.errors = Errors::default()),
    ("width", |t| t.errors.width_a_rad = 2.5e-5),
    ("csv", |t| {
        t.errors = Errors {
            csv: Some(PathBuf::from("new.errors.csv")),
            ..Errors::default()
        }
    }),
    ("tilt", |t| {
        if t.errors.csv.is_none() {
            t.errors.tilt = Some(Harmonic {
                amplitude_rad: 1e-5,
                phase_rad: 0.25,
            });
        }
    }),
    ("defect", |t| {
        t.local_defect.insert(
            0,
            LocalDefect {
                angle_rad: 1.0,
                width_rad: 0.01,
                error_rad: 1e-5,
                channel: None,
                edge: Some(Flank::Rise),
            },
        );
    }),
    ("no defect", |t| t.local_defect.clear()),
    ("friction", |t| t.shaft.coulomb_n_m = 1e-4),
    ("inertia", |t| t.shaft.inertia_kg_m2 *= 1.25),
    ("start", |t| t.shaft.initial_angle_rad = 0.5),
    ("ripple", |t| {
        t.ripple.push(Ripple {
            order: 3.0,
            phase_rad: 0.5,
            torque_n_m: Some(1e-5),
            speed_fraction: None,
        })
    }),
    ("ripple first", |t| {
        t.ripple.insert(
            0,
            Ripple {
                order: 2.0,
                phase_rad: 0.5,
                torque_n_m: Some(1e-5),
                speed_fraction: None,
            },
        )
    }),
    ("no ripple", |t| t.ripple.clear()),
    ("other ripple", |t| {
        t.ripple.iter_mut().for_each(|r| r.phase_rad += 0.125)
    }),
    ("gear", |t| {
        t.gear_mesh.push(Ripple {
            order: 7.5,
            phase_rad: 0.0,
            torque_n_m: Some(1e-5),
            speed_fraction: None,
        })
    }),
    ("bearing", |t| {
        t.bearing.push(Bearing {
            order: 0.43,
            phase_rad: 0.0,
            torque_n_m: None,
            speed_fraction: None,
            runout_rad: Some(1e-6),
        })
    }),
    ("bearing gone", |t| _ = t.bearing.pop()),
    ("tone", |t| {
        t.torque_tone.push(TorqueTone {
            f_hz: 50.0,
            phase_rad: 0.0,
            torque_n_m: Some(1e-6),
            speed_fraction: None,
        })
    }),
    ("load", |t| {
        t.load_step.insert(
            0,
            LoadStep {
                torque_n_m: -1e-6,
                from_s: 0.25,
                until_s: None,
            },
        )
    }),
    ("no noise", |t| t.noise = None),
    ("noise", |t| {
        t.noise = Some(Noise::White {
            psd_n2_m2_s: 1e-14,
            hold_s: Some(1e-3),
        })
    }),
    ("constant", |t| {
        if t.speed_drift.is_none() && t.stick_slip.is_none() {
            t.drive = Drive::Constant { r_min: 33.0 };
        }
    }),
    ("profile", |t| {
        if !matches!(t.drive, Drive::SpeedLoop { .. }) {
            t.drive = Drive::Profile(SpeedProfile::new(vec![
                Step {
                    t_s: 0.0,
                    r_min: 5.0,
                },
                Step {
                    t_s: 1.0,
                    r_min: 15.0,
                },
            ]));
        }
    }),
    ("resonance", |t| {
        t.torsional_resonance = Some(TorsionalResonance {
            f_hz: 80.0,
            damping_ratio: 0.0,
            inertia_share: 0.25,
            load_psd_n2_m2_s: None,
            load_hold_s: None,
        })
    }),
    ("delay", |t| {
        t.edge_delay = Some(EdgeDelay {
            a: RiseFall {
                rise_s: 1e-6,
                fall_s: 0.0,
            },
            ..EdgeDelay::default()
        })
    }),
    ("no delay", |t| t.edge_delay = None),
    ("skew", |t| {
        t.channel_skew = Some(ChannelSkew {
            a_s: 1e-7,
            ..ChannelSkew::default()
        })
    }),
    ("threshold", |t| {
        t.threshold_drift.push(ThresholdDrift {
            angle_rad: 1e-6,
            tau_s: 1.0,
            from_s: 0.0,
            channel: None,
        })
    }),
    ("hysteresis", |t| {
        t.hysteresis = Some(Hysteresis {
            angle_rad: 1e-5,
            channel: None,
        })
    }),
    ("no slip", |t| t.index_slip.clear()),
    ("latency", |t| {
        t.capture_latency = Some(CaptureLatency {
            mean_s: Some(1e-6),
            ..CaptureLatency::default()
        })
    }),
    ("clock", |t| t.timer.clock_hz = 16_000_000),
    ("jitter", |t| t.timer.jitter_s = 5e-8),
    ("faults", |t| t.faults.lost_edges = vec![5, 9]),
    ("no faults", |t| t.faults = Faults::default()),
];

#[test]
fn every_single_change_of_every_example_reads_back_and_keeps_the_other_lines() {
    let mut tried = 0;
    for (name, text) in examples() {
        for (what, change) in CHANGES {
            let mut new = Twin::parse(&text, &name).unwrap();
            change(&mut new);
            if new.check().is_err() {
                continue;
            }
            let edited = changed(&text, &name, change);
            let (_, less) = difference(&text, &edited);
            let first = text.lines().next().unwrap();
            assert!(edited.starts_with(first), "{what}: {edited}");
            assert!(less.len() <= 20, "{name}, {what}: {less:?}");
            tried += 1;
        }
    }
    assert!(tried > 300, "{tried}");
}

proptest! {
    #[test]
    fn changes_of_all_kinds_together_read_back(
        which in 0_usize..13,
        picks in subsequence((0..CHANGES.len()).collect::<Vec<_>>(), 2..9).prop_shuffle(),
    ) {
        let all = examples();
        let (name, text) = &all[which % all.len()];
        let mut new = Twin::parse(text, name).unwrap();
        for pick in &picks {
            let mut next = new.clone();
            (CHANGES[*pick].1)(&mut next);
            if next.check().is_ok() {
                new = next;
            }
        }
        let text = changed(text, name, |twin| *twin = new.clone());
        let written = new.to_toml().unwrap();
        prop_assert_ne!(&text, &written);
        // And on from there, with nothing left to change.
        prop_assert_eq!(changed(&text, name, |_| ()), text);
    }
}
