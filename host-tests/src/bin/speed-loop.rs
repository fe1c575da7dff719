//! Prints what a live speed loop hides and what is left once it is undone: `speed-loop [SEEDS]`.

use quadcal_host::free_run::Knowledge;
use quadcal_host_tests::accuracy::median;
use quadcal_host_tests::anywhere::Judged;
use quadcal_host_tests::speed_loop::{FAST, Run, SLOW, drawn, record, sweep};

const AS_GIVEN: Knowledge = Knowledge {
    gains_within: 0.0,
    phase: true,
};
const MEASURED: Knowledge = Knowledge {
    gains_within: 0.1,
    phase: true,
};

/// Seeds of the sweep over gains.
const SWEPT: u64 = 50;

fn main() {
    let seeds = std::env::args().nth(1).and_then(|text| text.parse().ok());
    let seeds: u64 = seeds.unwrap_or(3);
    println!("RMS error left over that of the encoder, median and worst of {seeds} seeds");
    println!("(at {SLOW} r/min of orders above 40 only)");
    for r_min in [SLOW, FAST] {
        println!("{r_min} r/min");
        let mut table: Vec<(String, Vec<f64>)> = Vec::new();
        for seed in 1..=seeds {
            for (row, (name, left)) in cases(seed, r_min).into_iter().enumerate() {
                if seed == 1 {
                    table.push((name, Vec::new()));
                }
                table[row].1.push(left);
            }
        }
        for (name, left) in table {
            print(&name, left);
        }
    }
    println!(
        "both together as quadcal calibrates, kp and ki each drawn within 10 %, {SWEPT} seeds"
    );
    let judged = sweep(1..=SWEPT);
    let over = |value: fn(&Judged) -> f64| judged.iter().map(value).collect();
    print("error left", over(|run| run.left / run.raw));
    print(
        "error left over its stated standard error",
        over(|run| run.left / run.standard_error),
    );
    let covered: f64 = judged.iter().map(|run| run.covered).sum();
    let share = 100.0 * covered / judged.len() as f64;
    println!("  within 1.96 standard errors: {share:.1} % of edges");
}

/// A row: median and worst.
fn print(name: &str, values: Vec<f64>) {
    let worst = values.iter().copied().fold(0.0, f64::max);
    println!("  {name:<44} {:9.5} {worst:9.5}", median(values));
}

fn cases(seed: u64, r_min: f64) -> Vec<(String, f64)> {
    let run = record(seed, r_min, 0);
    let mut cases = vec![
        ("as recorded".to_owned(), run.left_as_is()),
        (
            "gains exact".to_owned(),
            run.left_undone(run.off_by(1.0, 1.0), AS_GIVEN),
        ),
    ];
    let drawn = drawn(seed);
    let corners = [(1.1, 1.1), (1.1, 0.9), (0.9, 1.1), (0.9, 0.9)];
    let named = corners.map(|(kp, ki)| (format!("kp x {kp}, ki x {ki}"), kp, ki));
    let drawn = ("drawn within 10 %".to_owned(), drawn.kp, drawn.ki);
    for (name, kp, ki) in named.into_iter().chain([drawn]) {
        for (how, knowledge) in [("as given", AS_GIVEN), ("measured", MEASURED)] {
            let left = run.left_undone(run.off_by(kp, ki), knowledge);
            cases.push((format!("{name}, {how}"), left));
        }
    }
    let later = record(seed, r_min, 3217);
    let unknown = Knowledge {
        phase: false,
        ..MEASURED
    };
    cases.push((
        "kp x 1.1, ki x 0.9, sample time unknown".to_owned(),
        later.left_undone(later.off_by(1.1, 0.9), unknown),
    ));
    cases.extend(torques(&run, r_min));
    cases
}

fn torques(run: &Run, r_min: f64) -> Vec<(String, f64)> {
    // 12 bits over +-1 N m at the lower speed and +-4 N m, which the loop asks for, at the higher.
    let range = if r_min < 100.0 { 1.0 } else { 4.0 };
    let mut cases = Vec::new();
    for (bits, lsb) in [("", None), (", 12 bits", Some(range / 2048.0))] {
        for (place, at_edges, timed) in [
            ("changes", false, false),
            ("edges", true, false),
            ("edges, rate known", true, true),
        ] {
            let steps = run.torque(at_edges, lsb);
            let left = run.left_undone(run.torque_push(&steps, 1.0, timed), AS_GIVEN);
            cases.push((format!("torque recorded at {place}{bits}"), left));
        }
    }
    cases
}
