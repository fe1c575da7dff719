//! A speed loop that is not undone: which orders a calibration leaves alone for it.

mod workshop;

use std::fs;

use workshop::{TWIN, done, json};

#[test]
fn a_loop_hides_orders_by_the_slowest_turn_learned_from() {
    let folder = tempfile::tempdir().unwrap();
    let at = folder.path();
    let ramp = "[drive.ramp]\nfrom_r_min = 150\nto_r_min = 1200\nover_s = 1.7\n";
    let twin = TWIN.replace("[drive.constant]\nr_min = 600\n", ramp);
    fs::write(at.join("ramp.toml"), twin).unwrap();
    done(at, "simulate ramp.toml -o ramp.csv");
    let learned = |options: &str| {
        let arguments = format!("calibrate ramp.csv {options} -o t.qct --csv t.csv --json -");
        json(&done(at, &arguments))
    };
    let found = learned("--loop-hz 30");
    let slowest = found["turns"]["slowest_rev_per_min"].as_f64().unwrap();
    let turns_per_s = slowest / 60.0;
    let last = (2.0 * 30.0 / turns_per_s).ceil();
    assert_eq!(found["orders_hidden_up_to"].as_f64(), Some(last));
    assert_eq!(
        found["orders_left_alone_for_loop_up_to"].as_f64(),
        Some(last)
    );
    // At the mean speed of its twenty turns it would have been fewer.
    let seconds = found["recordings"][0]["seconds"].as_f64().unwrap();
    assert!(last > (2.0 * 30.0 * seconds / 20.0).ceil(), "{seconds} s");
    let text = done(at, "calibrate ramp.csv --loop-hz 30 -o t.qct");
    let said = format!("orders 1 to {last} left alone, as a speed loop may hide them");
    assert!(text.contains(&said), "{text}");
    // What was said of the orders goes before what was worked out.
    let found = learned("--loop-hz 30 --hidden-up-to 4");
    assert_eq!(found["orders_hidden_up_to"], 4);
    let found = learned("");
    assert_eq!(found["orders_left_alone_for_loop_up_to"], 0);
}

#[test]
fn a_loop_that_nobody_spoke_of_is_asked_about_and_nothing_is_promised() {
    let folder = tempfile::tempdir().unwrap();
    let at = folder.path();
    let twin = done(at, "simulate --example speed-loop");
    fs::write(at.join("loop.toml"), twin).unwrap();
    done(at, "simulate loop.toml -o loop.csv");
    let text = done(at, "calibrate loop.csv -o t.qct --report t.html");
    let question = text
        .lines()
        .find(|line| line.starts_with("Was a speed loop on?"));
    assert!(
        question.is_some_and(
            |line| line.contains("orders 5 to ") && line.contains("torque or voltage mode")
        ),
        "{text}"
    );
    assert!(
        text.contains("if no speed loop ran") && !text.contains("% off"),
        "{text}"
    );
    let page = fs::read_to_string(at.join("t.html")).unwrap();
    assert!(
        page.contains("Was a speed loop on?")
            && page.contains("not known: was a speed loop on?")
            && !page.contains("% off")
    );
    let found = json(&done(at, "calibrate loop.csv -o t.qct --json -"));
    assert_eq!(found["speed_loop_suspected"]["first_order"], 5);
    // Told of the loop, there is nothing to ask.
    let undone = json(&done(
        at,
        "calibrate loop.csv --twin loop.toml -o t.qct --json -",
    ));
    assert!(undone["speed_loop_suspected"].is_null());
}
