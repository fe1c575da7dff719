//! The edge path of a drive that can be calibrated in the field: what an edge costs in QEMU, and what its machine code holds.

use std::time::Duration;

use quadcal_host_tests::firmware::{build, offences, reachable, run_qemu};

const LIMIT: Duration = Duration::from_secs(120);

#[test]
fn an_edge_costs_little_more_while_it_learns_than_learning_itself() {
    let elf = build("edge_cost_field", &[]).unwrap_or_else(|error| panic!("{error}"));
    let folder = tempfile::tempdir().unwrap();
    let output =
        run_qemu(&elf, &[], folder.path(), LIMIT).unwrap_or_else(|error| panic!("{error}"));
    assert!(output.success, "{}", output.stderr);
    print!("{}", output.stdout);
    for (state, most) in [
        ("push_with_nothing_to_do", 83.0),
        ("push_learning", 232.0),
        ("push_proving", 530.0),
        ("push_comparing", 530.0),
    ] {
        let line = output
            .stdout
            .lines()
            .find_map(|line| line.strip_prefix(state)?.strip_prefix('='));
        let cost: f64 = line.unwrap_or_default().parse().unwrap();
        assert!((30.0..most).contains(&cost), "{state}: {cost}");
    }
}

/// One function does all of it, whatever the workbench has to do: correcting, learning, proving and comparing.
#[test]
fn the_edge_path_in_the_field_has_no_panic_no_division_and_no_float() {
    let elf = build("edge_cost_field", &[]).unwrap_or_else(|error| panic!("{error}"));
    let functions = reachable(&elf, "edge_cost_field::push_block");
    let functions = functions.unwrap_or_else(|error| panic!("{error}"));
    let names: Vec<&str> = functions.iter().map(|f| f.name.as_str()).collect();
    for part in ["::learn", "::prove", "Estimator<B>>::push_watchful"] {
        let there = names.iter().any(|name| name.ends_with(part));
        assert!(there, "{part} not in {names:?}");
    }
    assert_eq!(offences(&functions), []);
}
