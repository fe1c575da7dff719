//! No events where there are none.

use std::path::Path;

use super::*;

#[test]
fn a_shaft_that_turns_back_runs_down_or_is_loaded_makes_no_event() {
    for encoder in &sensors() {
        for seed in 1..=6 {
            let noisy = Twin {
                noise: Some(Noise::White {
                    psd_n2_m2_s: 1e-7,
                    hold_s: None,
                }),
                ..rig(encoder, seed)
            };
            let back = Drive::Ramp {
                from_r_min: 60.0,
                to_r_min: -60.0,
                over_s: 4.0,
            };
            let off = Drive::RunDown {
                r_min: 60.0,
                off_s: 2.0,
            };
            let mut drives = vec![off];
            // One channel does not see a reversal.
            if !matches!(encoder, Encoder::Wheel { .. }) {
                drives.push(back);
            }
            for drive in drives {
                let twin = Twin {
                    drive,
                    ..noisy.clone()
                };
                let found = events(&track(&twin));
                assert!(found.is_empty(), "{encoder:?} {seed}: {found:?}");
            }
            let mut loaded = noisy.clone();
            loaded.load_step = vec![twin::LoadStep {
                from_s: 2.0,
                until_s: None,
                torque_n_m: 3e-4,
            }];
            let found = events(&track(&loaded));
            assert!(found.is_empty(), "{encoder:?} {seed}: {found:?}");
        }
    }
}

#[test]
fn the_example_twins_have_the_events_that_they_declare_and_no_other() {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("twins");
    let mut tried = 0;
    for entry in std::fs::read_dir(folder).unwrap() {
        let path = entry.unwrap().path();
        if path.extension().is_none_or(|extension| extension != "toml") {
            continue;
        }
        let twin = Twin::load(&path).unwrap();
        if twin.timer.raw_captures {
            continue;
        }
        let found = events(&track(&twin));
        let slips: Vec<i32> = twin.index_slip.iter().map(|slip| slip.edges).collect();
        let seen: Vec<i32> = found.iter().map(|event| event.edges).collect();
        assert_eq!(seen, slips, "{path:?}: {found:?}");
        tried += 1;
    }
    assert!(tried > 5);
}
