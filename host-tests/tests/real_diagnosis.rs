//! Diagnoses of the Hall recordings that are shipped.

use std::path::Path;

use quadcal_host_tests::real::command::Bench;
use quadcal_host_tests::real::hall;
use quadcal_host_tests::real::line::Line;

fn missed(lines: Vec<Line>) -> Vec<String> {
    let missed = lines.into_iter().filter(|line| !line.met);
    missed.map(|line| line.to_string()).collect()
}

fn lines(of: fn(&Bench, &Path) -> anyhow::Result<Vec<Line>>) -> Vec<Line> {
    let folder = tempfile::tempdir().unwrap();
    let bench = Bench {
        program: env!("CARGO_BIN_EXE_quadcal-under-test").into(),
        arguments: Vec::new(),
        folder: folder.path().to_owned(),
    };
    let recordings = Path::new(env!("CARGO_MANIFEST_DIR")).join("../host/recordings");
    of(&bench, &recordings).unwrap()
}

/// One figure of each is not reached yet.
fn few_missed(of: fn(&Bench, &Path) -> anyhow::Result<Vec<Line>>) {
    let missed = missed(lines(of));
    assert!(missed.len() <= 1, "{missed:?}");
}

#[test]
fn a_spindle_s_delay_is_found_and_explains_turns_that_were_not_used() {
    few_missed(hall::spindle);
}

#[test]
fn a_hub_motor_s_delay_is_said_to_be_poorly_known() {
    few_missed(hall::hub);
}
