//! Starts without an index: `cargo run --release -p quadcal-host-tests --bin locate -- [--starts N] [--discs N]`.
#![forbid(unsafe_code)]
#![allow(clippy::cast_precision_loss)]

use clap::Parser;
use quadcal_host_tests::locate::{BLOCKS, Case, Disc, End, SLICE, Start, Table};

/// Finds the place in the table from random starts, and refuses other discs' tables.
#[derive(Parser)]
struct Options {
    /// Starts a case with the disc's own table, and as many with another's.
    #[arg(long, default_value_t = 1000)]
    starts: usize,
    /// Discs that the starts are spread over.
    #[arg(long, default_value_t = 25)]
    discs: usize,
    /// Probability asked for: 2^-BITS.
    #[arg(long, default_value_t = 24)]
    bits: u8,
    /// Only this case, by its number from 0.
    #[arg(long)]
    case: Option<usize>,
    /// First seed.
    #[arg(long, default_value_t = 1)]
    first: u64,
}

fn main() {
    let options = Options::parse();
    println!(
        "windows of {} edges, {SLICE} half blocks an edge",
        16 * BLOCKS
    );
    for (number, case) in Case::ALL.into_iter().enumerate() {
        if options.case.is_none_or(|only| only == number) {
            sweep(case, &options);
        }
    }
}

fn sweep(case: Case, options: &Options) {
    let discs: Vec<Disc> = (0..options.discs as u64)
        .map(|i| Disc::new(case, options.first + i))
        .collect();
    let (mut own, mut other) = (Vec::new(), Vec::new());
    for i in 0..options.starts {
        let at = i % discs.len();
        // Fractions of the golden section: even over the turn, whatever the number.
        let fraction = (i as f64 * 0.618_033_988_749_895).fract();
        let others = discs.len() - 1;
        own.push(discs[at].start(discs[at].table(), fraction, options.bits));
        if others > 0 {
            let stranger = &discs[(at + 1 + i / discs.len() % others) % discs.len()];
            other.push(discs[at].start(stranger.table(), fraction, options.bits));
        }
    }
    println!("{}", case.name());
    print("own table", &own);
    print("another's", &other);
    for name in ["own", "slipped by a line", "another's"] {
        let table = |at: usize| -> Table {
            let (own, next) = (&discs[at], &discs[(at + 1) % discs.len()]);
            match name {
                "own" => own.table().clone(),
                "another's" => next.table().clone(),
                _ => own.table().slipped(1),
            }
        };
        let watch = |at: usize| discs[at].watch(&table(at), options.bits);
        let alarms: Vec<u32> = (0..discs.len()).filter_map(watch).collect();
        println!(
            "  in use from the index on, {name}: {} alarms in {} runs, latest after {:?} edges",
            alarms.len(),
            discs.len(),
            alarms.iter().max()
        );
    }
}

fn print(name: &str, starts: &[Start]) {
    let count = |pick: &dyn Fn(&End) -> bool| starts.iter().filter(|s| pick(&s.end)).count();
    let right = count(&|end| matches!(end, End::Right(_)));
    let wrong = count(&|end| matches!(end, End::Wrong(_)));
    let refused = count(&|end| matches!(end, End::Refused(_)));
    let told = count(&|end| matches!(end, End::Open { told: true }));
    let silent = count(&|end| matches!(end, End::Open { told: false }));
    let mut edges: Vec<u32> = starts
        .iter()
        .filter(|s| !matches!(s.end, End::Open { .. }))
        .map(|s| s.edges)
        .collect();
    edges.sort_unstable();
    let at = |share: f64| {
        edges
            .get(((edges.len() as f64 - 1.0) * share) as usize)
            .copied()
    };
    println!(
        "  {name}: {right} right, {wrong} wrong, {refused} refused, {told} can't tell, {silent} silent of {}; edges median {:?}, \
         99.9 % {:?}, most {:?}",
        starts.len(),
        at(0.5),
        at(0.999),
        at(1.0)
    );
}
