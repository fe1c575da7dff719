//! The C library: its example program, compiled by a C compiler and run in QEMU, against the core on the host.

use std::path::{Path, PathBuf};
use std::time::Duration;

use quadcal::decoder::{DecoderConfig, QuadratureDecoder};
use quadcal::edge::{Levels, Sample};
use quadcal::encoder::{Capture, Encoder, EncoderConfig};
use quadcal::estimate::{Anchor, Estimator, Progress, StaticBuffers};
use quadcal::shape::EncoderShape;
use quadcal::slot::{self, Slot, SlotHeader};
use quadcal_host_tests::firmware::{
    c_library, c_program, offences, reachable, run_qemu, size, workspace,
};

const LIMIT: Duration = Duration::from_secs(60);
const LINES: u32 = 90;
const CLOCK_HZ: u64 = 84_000_000;

/// The library and a folder for programs.
struct Bench {
    library: PathBuf,
    folder: tempfile::TempDir,
}

impl Bench {
    fn new() -> Self {
        Self {
            library: c_library().unwrap_or_else(|error| panic!("{error}")),
            folder: tempfile::tempdir().unwrap(),
        }
    }

    fn program(&self, name: &str, keep: &[&str]) -> PathBuf {
        c_program(name, &self.library, self.folder.path(), keep)
            .unwrap_or_else(|error| panic!("{error}"))
    }

    /// What a program prints, line by line: a word and numbers.
    fn lines(&self, elf: &Path) -> Vec<(String, Vec<u64>)> {
        let output =
            run_qemu(elf, &[], self.folder.path(), LIMIT).unwrap_or_else(|error| panic!("{error}"));
        let last = output.stdout.lines().last().unwrap_or_default();
        assert!(output.success, "{last} {}", output.stderr);
        let lines = output.stdout.lines().map(|line| {
            let mut words = line.split(' ');
            let name = words.next().unwrap().to_owned();
            (name, words.map(|word| word.parse().unwrap()).collect())
        });
        lines.collect()
    }
}

/// The encoder on the host, fed as the C program is.
struct Host<'a> {
    encoder: Encoder<'a, [u8; 2], 16>,
    wraps: u64,
}

impl Host<'_> {
    fn new() -> Self {
        let config = EncoderConfig::new(LINES, CLOCK_HZ / 10);
        Self {
            encoder: Encoder::new(config, None).unwrap(),
            wraps: 0,
        }
    }

    /// Status, angle, interval and speed of an edge; angle and speed 9000 ticks later.
    fn serve(&mut self, ticks: u64, levels: Levels) -> Vec<u64> {
        while self.wraps < ticks >> 16 {
            self.wraps += 1;
            self.encoder.overflow();
        }
        let seen = self.encoder.edge(Capture {
            raw: (ticks & 0xFFFF) as u32,
            overflow_pending: false,
            levels,
        });
        let now = ticks + 9000;
        let [angle, interval] = seen.map_or([0; 2], |seen| [seen.edge.angle.0, seen.edge.interval]);
        let speed = seen.map_or(0, |seen| seen.speed().0);
        let angle_now = self.encoder.now(now).map_or(0, |angle| angle.0);
        vec![
            u64::from(seen.is_none()),
            angle.into(),
            interval.into(),
            speed.cast_unsigned(),
            angle_now.into(),
            self.encoder.speed_at(now).0.cast_unsigned(),
        ]
    }
}

fn levels(number: u64) -> Levels {
    Levels(number as u8)
}

/// The table's bytes that the core learns from the same samples.
fn learned(samples: &[Sample]) -> Vec<u8> {
    let shape = EncoderShape::new(4 * LINES, 4).unwrap();
    let buffers: StaticBuffers<{ LINES as usize }, 4> = StaticBuffers::new();
    let mut estimator = Estimator::new(shape, Anchor::Index, buffers).unwrap();
    let mut decoder = QuadratureDecoder::new(DecoderConfig::new(LINES)).unwrap();
    let mut until = 0;
    for sample in samples {
        if let Progress::TurnTaken(_) = estimator.push(&decoder.push(*sample)) {
            until = sample.ticks;
        }
    }
    let solution = estimator.solve().unwrap();
    let header = SlotHeader::of(&solution, until, CLOCK_HZ);
    let mut bytes = Vec::new();
    slot::write(&header, solution.entries(), |piece| {
        bytes.extend_from_slice(piece);
        Ok::<(), ()>(())
    })
    .unwrap();
    bytes
}

#[test]
fn a_c_program_in_qemu_gives_what_the_core_gives_on_the_host() {
    let bench = Bench::new();
    for name in ["edges.elf", "learn.elf"] {
        let elf = bench.program(name, &[]);
        println!("{name}: {:?}", size(&elf).unwrap());
        let lines = bench.lines(&elf);
        assert_eq!(lines[0].0, "QUADCAL_ERROR_NOT_INITIALISED");
        let numbers = |kind: &str| {
            lines
                .iter()
                .find(|(name, _)| name == kind)
                .map(|line| &line.1)
        };
        let table = numbers("table").cloned().unwrap_or_default();
        let table: Vec<u8> = table.into_iter().map(|byte| byte as u8).collect();
        let mut host = Host::new();
        let mut samples = Vec::new();
        let mut compared = 0;
        for (kind, numbers) in &lines {
            match kind.as_str() {
                "edge" => {
                    let expected = host.serve(numbers[0], levels(numbers[1]));
                    assert_eq!(numbers[2..], expected, "{name}: {numbers:?}");
                    compared += 1;
                }
                "learn" => {
                    let sample = Sample {
                        ticks: numbers[0],
                        levels: levels(numbers[1]),
                    };
                    host.serve(sample.ticks, sample.levels);
                    samples.push(sample);
                }
                "table" => {
                    assert!(table == learned(&samples), "the tables differ");
                    let slot = Slot::parse(&table).unwrap();
                    let table = slot.table_at(CLOCK_HZ).unwrap();
                    host.encoder.set_table(Some(table)).unwrap();
                }
                _ => {}
            }
        }
        assert_eq!(compared, 6 * 4 * LINES);
        assert_eq!(samples.is_empty(), name == "edges.elf");
        assert_eq!(numbers("state").unwrap()[2..], [1, 0, 0]);
        if !samples.is_empty() {
            println!(
                "{name}: {} samples learned from, {:?} slices",
                samples.len(),
                numbers("slices")
            );
            // The pretended shaft turns evenly: with the table every speed is the mean one.
            let speeds = lines
                .iter()
                .filter(|(kind, _)| kind == "edge")
                .skip(6 * 4 * LINES as usize - 300);
            let mean = -((1_i64 << 60) / i64::from(4 * LINES) / 23_333);
            for (_, numbers) in speeds {
                let off = numbers[5].cast_signed() as f64 / mean as f64 - 1.0;
                assert!(off.abs() < 3e-3, "{off}");
            }
        }
    }
}

#[test]
fn no_function_of_the_library_but_solving_can_come_to_a_panic() {
    let bench = Bench::new();
    let header = std::fs::read_to_string(workspace().join("c/include/quadcal.h")).unwrap();
    let before_brackets = header.lines().filter(|line| !line.starts_with("//"));
    let mut names: Vec<&str> = before_brackets
        .filter_map(|line| line.split_once('(')?.0.split([' ', '*']).next_back())
        .filter(|name| name.starts_with("quadcal_"))
        .collect();
    assert_eq!(names.len(), 18, "{names:?}");
    names.retain(|name| *name != "quadcal_learn_slice");
    let elf = bench.program("edges.elf", &names);
    println!(
        "with every function but quadcal_learn_slice: {:?}",
        size(&elf).unwrap()
    );
    // Solving checks bounds, so that the proof has something to find.
    let solving = tempfile::tempdir().unwrap();
    let found = c_program(
        "edges.elf",
        &bench.library,
        solving.path(),
        &["quadcal_learn_slice"],
    );
    let error = found.unwrap_err().to_string();
    assert!(error.contains("quadcal_a_panic_can_be_reached"), "{error}");
}

#[test]
fn edges_and_reads_have_no_panic_no_division_and_no_float() {
    let bench = Bench::new();
    let elf = bench.program("edges.elf", &["quadcal_time"]);
    for name in [
        "quadcal_overflow",
        "quadcal_edge",
        "quadcal_time",
        "quadcal_angle",
        "quadcal_speed",
    ] {
        assert_eq!(offences(&reachable(&elf, name).unwrap()), [], "{name}");
    }
}
