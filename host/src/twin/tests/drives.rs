use super::*;

const ENCODER: &str =
    "duration.seconds = 1\n[encoder.quadrature]\nlines = 100\n[timer]\nclock_hz = 1e6\n";

#[test]
fn a_twin_needs_neither_drive_nor_shaft() {
    let twin = Twin::parse(ENCODER, "rig.toml").unwrap();
    assert_eq!(
        (&twin.drive, twin.shaft.inertia_kg_m2),
        (&Drive::Unknown, 0.0)
    );
    assert_eq!(
        Twin::parse(&twin.to_toml().unwrap(), "rig.toml").unwrap(),
        twin
    );
    let shown = crate::sim::Simulation::new(&twin).unwrap_err().to_string();
    assert!(
        shown.starts_with("rig.toml: no [drive]; ") && shown.contains("[drive.constant]"),
        "{shown}"
    );
    assert_eq!(crate::sim::true_errors(&twin).unwrap(), [0.0; 400]);
}

#[test]
fn what_is_a_torque_asks_for_the_inertia_by_its_own_key() {
    let drive = "[drive.constant]\nr_min = 60\n";
    for (more, key) in [
        ("[shaft]\nviscous_n_m_s = 1e-3\n", "shaft.viscous_n_m_s"),
        ("[shaft]\nstiffness_n_m_s = 1e-3\n", "shaft.stiffness_n_m_s"),
        (
            "[[ripple]]\norder = 1\nspeed_fraction = 0.1\n[[ripple]]\norder = 2\ntorque_n_m = 1\n",
            "ripple[1].torque_n_m",
        ),
        (
            "[[load_step]]\nfrom_s = 0\ntorque_n_m = 1\n",
            "load_step[0].torque_n_m",
        ),
        (
            "[noise.white]\npsd_n2_m2_s = 1e-9\n",
            "noise.white.psd_n2_m2_s",
        ),
        (
            "[stick_slip]\nstiffness_n_m_rad = 1e-9\n",
            "stick_slip.stiffness_n_m_rad",
        ),
    ] {
        let text = format!("{ENCODER}{drive}{more}");
        let bad = bad_value(&text);
        assert_eq!(bad.key, key);
        let name = key.rsplit('.').next().unwrap();
        let line = text.lines().position(|l| l.starts_with(name)).unwrap() + 1;
        assert_eq!(bad.place.position.map(|p| p.0), Some(line), "{key}");
        let given = "[shaft]\ninertia_kg_m2 = 1e-4\n";
        let with = if more.starts_with("[shaft]\n") {
            format!("{ENCODER}{drive}{}", more.replace("[shaft]\n", given))
        } else {
            format!("{text}{given}")
        };
        Twin::parse(&with, "rig.toml").unwrap();
    }
    for torque in [
        "[drive.torque]\npoints = [{ t_s = 0, torque_n_m = 1 }]\n",
        "[drive.speed_loop]\nr_min = 60\nf_hz = 100\nkp_n_m_s = 1\nki_n_m = 1\n",
    ] {
        let bad = bad_value(&format!("{ENCODER}{torque}"));
        assert!(bad.key.starts_with("drive."), "{}", bad.key);
    }
    let zero = format!("{ENCODER}[shaft]\ninertia_kg_m2 = 0\n");
    match Twin::parse(&zero, "rig.toml") {
        Err(TwinError::Syntax { key, place, .. }) => {
            assert_eq!(
                (key.as_str(), place.position.map(|p| p.0)),
                ("shaft.inertia_kg_m2", Some(7))
            );
        }
        other => panic!("{other:?}"),
    }
}

#[test]
fn a_curve_s_points_are_kept_and_ones_out_of_order_are_placed() {
    let text = format!(
        "{ENCODER}[drive.profile]\npoints = [{{ t_s = 0.5, r_min = 0 }}, {{ t_s = 1, r_min = 60 }}]\n"
    );
    let twin = Twin::parse(&text, "rig.toml").unwrap();
    assert_eq!(twin.drive.nominal_rad_s(), std::f64::consts::TAU);
    assert_eq!(
        Twin::parse(&twin.to_toml().unwrap(), "rig.toml").unwrap(),
        twin
    );
    let bad = bad_value(&text.replace("t_s = 1,", "t_s = 0.4,"));
    assert_eq!(
        (bad.key.as_str(), bad.place.position.map(|p| p.0)),
        ("drive.profile.points[1].t_s", Some(7))
    );
    for keys in ["", "csv = \"x.csv\"\npoints = [{ t_s = 0, r_min = 1 }]\n"] {
        let folder = tempfile::tempdir().unwrap();
        std::fs::write(folder.path().join("x.csv"), "t_s,r_min\n0,1\n").unwrap();
        let name = folder.path().join("rig.toml").display().to_string();
        match Twin::parse(&format!("{ENCODER}[drive.profile]\n{keys}"), &name) {
            Err(TwinError::Value(bad)) => assert_eq!(bad.key, "drive.profile"),
            other => panic!("{other:?}"),
        }
    }
}

#[test]
fn a_curve_is_read_from_csv_and_its_faults_are_placed() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("speed.csv");
    let name = folder.path().join("rig.toml").display().to_string();
    let read = |csv: &str| {
        std::fs::write(&path, csv).unwrap();
        Twin::parse(
            &format!("{ENCODER}[drive.profile]\ncsv = \"speed.csv\"\n"),
            &name,
        )
    };
    let twin = read("torque_n_m, t_s, r_min\n9, 0, 10\n9, 1, 20\n").unwrap();
    let Drive::Profile(profile) = &twin.drive else {
        panic!()
    };
    let points: Vec<(f64, f64)> = profile.points().iter().map(|p| (p.t_s, p.r_min)).collect();
    assert_eq!(points, [(0.0, 10.0), (1.0, 20.0)]);
    for (csv, line, says) in [
        ("t_s,speed\n0,1\n", 1, "header t_s,r_min"),
        ("t_s,r_min\n0,x\n", 2, "r_min = 'x'"),
        ("t_s,r_min\n1,0\n0,0\n", 3, "t_s = 0: allowed is 1 to "),
        ("t_s,r_min\n1,2e6\n", 2, "r_min = 2000000"),
        ("t_s,r_min\nnan,2\n", 2, "t_s = NaN"),
        ("t_s,r_min\n", 1, "no row"),
    ] {
        let shown = read(csv).unwrap_err().to_string();
        assert!(shown.contains(&format!("speed.csv:{line}: ")), "{shown}");
        assert!(shown.contains(says) && !shown.contains('\n'), "{shown}");
    }
    for gone in ["nothing.csv", "."] {
        let text = format!("{ENCODER}[drive.profile]\ncsv = \"{gone}\"\n");
        assert!(
            matches!(Twin::parse(&text, &name), Err(TwinError::CsvFile { .. })),
            "{gone}"
        );
    }
}
