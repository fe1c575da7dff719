use super::*;
use crate::diagnose::spread::Spread;
use crate::reports::diagnose::example;
use crate::sim::Simulation;

const RIG: &str = include_str!("../../../../twins/pair-slow.toml");

fn twin(name: &str) -> Twin {
    Twin::parse(RIG, name).unwrap()
}

fn disc(errors_rad: Vec<f64>) -> LearnedDisc {
    LearnedDisc {
        errors_rad,
        spread: Spread {
            edge_rad: 1.5e-6,
            waves_rad: vec![3e-6],
        },
    }
}

/// A diagnosis of two recordings of one rig.
fn full() -> Diagnosed {
    Diagnosed {
        diagnosis: example::full().diagnosis,
        twins: vec![twin("slow.toml"), twin("fast.toml")],
        discs: vec![None, None],
    }
}

#[test]
fn every_recording_has_its_twin_and_equal_ones_share_a_file() {
    let mut diagnosed = full();
    diagnosed.twins[1].seed += 1;
    let paths = |diagnosed: &Diagnosed| -> Vec<String> {
        let files = files(Path::new("out/new.toml"), diagnosed, &[]).unwrap();
        files.iter().map(|f| f.path.display().to_string()).collect()
    };
    assert_eq!(paths(&diagnosed), ["out/new.toml", "out/new-2.toml"]);
    diagnosed.twins = vec![twin("rig.toml"); 2];
    assert_eq!(paths(&diagnosed), ["out/new.toml"]);
    let all = names(Path::new("out/new.toml"), 2);
    for name in [
        "new.toml",
        "new-2.toml",
        "new.errors.csv",
        "new-2.errors.csv",
    ] {
        assert!(all.contains(&Path::new("out").join(name)), "{all:?}");
    }
}

#[test]
fn a_learned_disc_goes_beside_its_twin_and_is_read_again() {
    let folder = tempfile::tempdir().unwrap();
    let mut diagnosed = full();
    let edges = diagnosed.twins[0].encoder.grid_edges();
    let list: Vec<f64> = (0..edges).map(|k| 1e-9 * f64::from(k)).collect();
    diagnosed.twins.truncate(1);
    diagnosed.discs = vec![Some(disc(list.clone()))];
    let first = folder.path().join("new.toml");
    for file in files(&first, &diagnosed, &[]).unwrap() {
        fs::write(file.path, file.text).unwrap();
    }
    let read = Twin::load(&first).unwrap();
    assert_eq!(read.errors.csv, Some("new.errors.csv".into()));
    assert_eq!(Simulation::new(&read).unwrap().true_errors(), list);
    let spread_rad = crate::sim::disc_spread_rad(&read).unwrap();
    assert!((spread_rad - 1.5e-6).abs() < 1e-12, "{spread_rad}");
    assert_eq!(read.errors.wave_standard_errors_rad, [3e-6]);
    let text = fs::read_to_string(&first).unwrap();
    let twin = &diagnosed.diagnosis.recordings[0].twin;
    let remark = format!("# {twin} with what 'quadcal diagnose' found missing on slow.csv.");
    assert!(text.starts_with(&remark), "{text}");
    let found = &diagnosed.diagnosis.findings[0];
    assert!(text.contains(&format!("# {}: {}", found.mechanism, found.text)));
    for wrong in [edges - 1, edges + 1] {
        diagnosed.discs = vec![Some(disc(vec![0.0; wrong as usize]))];
        assert!(files(&first, &diagnosed, &[]).is_err(), "{wrong}");
    }
}

#[test]
fn a_wheel_that_was_seen_by_one_edge_of_each_tooth_gets_both() {
    let text = include_str!("../../../../twins/wheel-60-2.toml");
    let wheel = Twin::parse(text, "wheel.toml").unwrap();
    let list = disc(vec![2.5e-3; 60]);
    let csv = list_csv(Path::new("w.csv"), &list, &wheel).unwrap();
    assert_eq!(csv.lines().count(), 121);
    assert_eq!(csv.lines().last(), Some("119,2.5e-3,1.500e-6"));
}

#[test]
fn a_list_is_found_from_the_new_twins_folder() {
    let folder = tempfile::tempdir().unwrap();
    let at = |name: &str| folder.path().join(name);
    fs::create_dir_all(at("rig/deep")).unwrap();
    fs::create_dir_all(at("out")).unwrap();
    fs::write(at("rig/e.csv"), "k").unwrap();
    for (old, new) in [
        ("rig", "out/new.toml"),
        ("rig", "new.toml"),
        ("rig", "rig/deep/new.toml"),
        ("rig", "rig/new.toml"),
    ] {
        let moved = moved(Path::new("e.csv"), &at(old), &at(new));
        assert!(moved.is_relative(), "{moved:?}");
        let found = at(new).parent().unwrap().join(&moved);
        assert_eq!(fs::read(&found).unwrap(), b"k", "{found:?}");
    }
    let same = moved(Path::new("e.csv"), &at("rig"), &at("rig/new.toml"));
    assert_eq!(same, Path::new("e.csv"));
    let absolute = at("rig/e.csv");
    assert_eq!(moved(&absolute, &at("rig"), &at("out/n.toml")), absolute);
}
