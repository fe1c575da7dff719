//! A device under arbitrary input: `cargo run --release -p quadcal-host-tests --bin fuzz-device -- [--inputs N] [--threads N]`.
//!
//! No panic, no input without end, no change without leave; ends with exit code 1 otherwise.
#![forbid(unsafe_code)]
#![allow(clippy::cast_precision_loss)]

use std::process::ExitCode;
use std::sync::Arc;
use std::sync::atomic::{AtomicU64, Ordering};
use std::thread::{self, JoinHandle};
use std::time::{Duration, Instant};

use clap::Parser;
use quadcal_host_tests::fuzz_device::{self, subject::Tally};

/// Feeds random, mutated and well-formed inputs to a device and holds it to a model of who may change what.
#[derive(Parser)]
struct Options {
    /// Inputs in total.
    #[arg(long, default_value_t = 1_000_000)]
    inputs: u64,
    /// Threads that share them.
    #[arg(long, default_value_t = 2)]
    threads: u64,
    /// First seed; each thread has its own.
    #[arg(long, default_value_t = 1)]
    seed: u64,
}

/// Time for one input, after which it is taken to have no end.
const PATIENCE: Duration = Duration::from_secs(20);

/// What must have been seen in a run of any length.
const NEEDED: &[&str] = &[
    "admitted",
    "session opened",
    "written",
    "reply Refused Replayed",
    "reply Refused WrongProof",
    "reply Refused Wait",
    "reply Written, whole",
    "stage WaitingForMotion",
    "stage CheckingSpeed",
    "stage Learning",
    "stage Solving",
    "stage Proving",
    "stage ReadyToCommit",
    "stage Committing",
    "stage Done",
];

struct Worker {
    seed: u64,
    done: Arc<AtomicU64>,
    handle: JoinHandle<Tally>,
}

fn main() -> ExitCode {
    let options = Options::parse();
    let threads = options.threads.max(1);
    let begin = Instant::now();
    let workers: Vec<Worker> = (0..threads)
        .map(|thread| {
            let share = options.inputs / threads + u64::from(thread < options.inputs % threads);
            let seed = options.seed + thread;
            let done = Arc::new(AtomicU64::new(0));
            let count = done.clone();
            let handle = thread::spawn(move || fuzz_device::run(seed, share, &count));
            Worker { seed, done, handle }
        })
        .collect();
    if let Err(seed) = watch(&workers) {
        eprintln!("an input of seed {seed} has no end");
        return ExitCode::FAILURE;
    }
    let (mut tally, mut total, mut failed) = (Tally::default(), 0, false);
    for worker in workers {
        let done = worker.done.load(Ordering::Relaxed);
        total += done;
        match worker.handle.join() {
            Ok(counts) => tally.merge(&counts),
            Err(_) => {
                eprintln!("seed {} failed at input {done}", worker.seed);
                failed = true;
            }
        }
    }
    let time = begin.elapsed().as_secs_f64();
    for (name, count) in &tally.counts {
        println!("{count:>12}  {name}");
    }
    println!(
        "{total} inputs in {time:.1} s, {:.0} a second",
        total as f64 / time
    );
    for name in NEEDED {
        if !failed && !tally.counts.contains_key(*name) {
            eprintln!("never seen: {name}");
            failed = true;
        }
    }
    ExitCode::from(u8::from(failed))
}

/// Waits for all to end; the seed of one that no longer gets on.
fn watch(workers: &[Worker]) -> Result<(), u64> {
    let mut last: Vec<(u64, Instant)> = workers.iter().map(|_| (0, Instant::now())).collect();
    while workers.iter().any(|worker| !worker.handle.is_finished()) {
        thread::sleep(Duration::from_millis(20));
        for (worker, last) in workers.iter().zip(&mut last) {
            let done = worker.done.load(Ordering::Relaxed);
            if done != last.0 || worker.handle.is_finished() {
                *last = (done, Instant::now());
            } else if last.1.elapsed() > PATIENCE {
                return Err(worker.seed);
            }
        }
    }
    Ok(())
}
