//! Firmware images in QEMU against the same session on the host, on the simulator's edges.

use std::path::PathBuf;
use std::time::Duration;

use quadcal::replay::corrected::CorrectedFile;
use quadcal::replay::{Event, Header, TimerWidth, Wiring};
use quadcal_host_tests::events::{Latency, events};
use quadcal_host_tests::firmware::{
    FirmwareError, Output, build, offences, reachable, run_qemu, size, symbols,
};
use quadcal_host_tests::rig::Rig;
use quadcal_host_tests::session;

const LIMIT: Duration = Duration::from_secs(120);

/// All that a calibration may take, stack included.
const RAM: u64 = 96 << 10;

const EVENTS: &str = "events.qcev";
const SLOT: &str = "table.qctb";
const CORRECTED: &str = "corrected.qcce";

fn image(name: &str) -> PathBuf {
    build(name, &[]).unwrap_or_else(|error| panic!("{error}"))
}

/// A folder with an event file in it, in which an image runs.
struct Bench {
    folder: tempfile::TempDir,
    elf: PathBuf,
}

impl Bench {
    fn new(image_name: &str, events: &[u8]) -> Self {
        let folder = tempfile::tempdir().unwrap();
        std::fs::write(folder.path().join(EVENTS), events).unwrap();
        Self {
            folder,
            elf: image(image_name),
        }
    }

    fn run(&self, args: &[&str]) -> Output {
        run_qemu(&self.elf, args, self.folder.path(), LIMIT)
            .unwrap_or_else(|error| panic!("{error}"))
    }

    fn succeed(&self, args: &[&str]) -> Output {
        let output = self.run(args);
        assert!(output.success, "{}", output.stderr);
        output
    }

    fn written(&self, name: &str) -> Vec<u8> {
        std::fs::read(self.folder.path().join(name)).unwrap()
    }
}

fn number(output: &Output, key: &str) -> u64 {
    output
        .value(key)
        .unwrap_or_else(|| panic!("no {key} in {}", output.stdout))
}

/// Wraps, and captures that a late handler found with the wrap pending: made before it, and after it.
fn races(events: &[Event], timer: TimerWidth) -> [usize; 3] {
    let pending = |event: &Event, after: bool| matches!(*event, Event::Capture { raw, overflow_pending: true, .. } if (raw <= timer.max() / 2) == after);
    [
        events.iter().filter(|e| **e == Event::Overflow).count(),
        events.iter().filter(|e| pending(e, false)).count(),
        events.iter().filter(|e| pending(e, true)).count(),
    ]
}

/// Replays a rig on image and host. Every byte must be alike; the table must make the encoder's RMS error smaller by `gain`.
fn image_and_host_agree(rig: Rig, gain: f64) {
    let image_name = format!("qemu_replay_{}", rig.lines);
    let run = rig.run().unwrap();
    let events = run.file();
    let races = races(&run.events.events, rig.timer);
    assert!(races.iter().all(|count| *count > 0), "{races:?}");
    let host = session::run(&events).unwrap();
    let bench = Bench::new(&image_name, &events);
    let output = bench.succeed(&[EVENTS, SLOT, CORRECTED]);
    assert!(bench.written(SLOT) == host.slot, "the slots differ");
    assert!(
        bench.written(CORRECTED) == host.corrected,
        "the corrected files differ"
    );

    let file = CorrectedFile::parse(&host.corrected).unwrap();
    assert_eq!(file.faults, host.report.faults);
    assert_eq!(file.edges().len() as u64, number(&output, "corrected"));
    let learned = host.report.learned;
    assert!(
        learned.turns == rig.turns && learned.broken >= 1,
        "{learned:?}"
    );
    assert_eq!(number(&output, "broken"), u64::from(learned.broken));

    let table_gain = run.table_gain(&host.slot).unwrap();
    let (angle_gain, sure) = run.angle_gain(&file);
    let (stack, fixed) = (
        number(&output, "stack_bytes"),
        number(&output, "static_bytes"),
    );
    println!(
        "{rig:?}: {} events, wraps and races {races:?}; error RMS down by a factor of {table_gain:.1} (table), {angle_gain:.1} \
         ({sure} of {} corrected edges); {learned:?}; {:?}; RAM {} = {fixed} static + {stack} stack",
        run.events.events.len(),
        file.edges().len(),
        file.faults,
        fixed + stack,
    );
    assert!(file.edges().any(|edge| edge.moved.0 > 0) && file.edges().any(|edge| edge.moved.0 < 0));
    assert!(
        file.faults.illegal >= 1 && file.faults.glitch >= 1,
        "{:?}",
        file.faults
    );
    assert!(table_gain > gain, "factor {table_gain}");
    assert!(
        sure > 4 * rig.lines as usize && angle_gain > gain,
        "factor {angle_gain} on {sure} edges"
    );
    let size = size(&bench.elf).unwrap();
    assert!(
        fixed.abs_diff(size.data + size.bss) < 8,
        "{fixed} bytes of statics, ELF has {size:?}"
    );
    // The paint can't tell how deep a stack goes that fills its whole region.
    assert!((1000..40 << 10).contains(&stack), "{stack} bytes of stack");
    assert!(fixed + stack <= RAM, "{fixed} + {stack} bytes of RAM");
}

const fn rig(lines: u32, timer: TimerWidth, turns: u32, seed: u64) -> Rig {
    Rig {
        lines,
        timer,
        turns,
        seed,
    }
}

#[test]
fn ten_thousand_edges_and_a_16_bit_timer_agree_byte_for_byte() {
    image_and_host_agree(rig(2500, TimerWidth::Bits16, 5, 1), 10.0);
}

#[test]
fn ten_thousand_edges_and_a_32_bit_timer_agree_byte_for_byte() {
    image_and_host_agree(rig(2500, TimerWidth::Bits32, 5, 2), 10.0);
}

#[test]
fn a_small_encoder_agrees_byte_for_byte_with_either_timer() {
    image_and_host_agree(rig(360, TimerWidth::Bits16, 8, 3), 10.0);
    image_and_host_agree(rig(360, TimerWidth::Bits32, 8, 4), 10.0);
}

/// A short run for the tests that need some events.
fn short() -> Vec<u8> {
    let rig = rig(360, TimerWidth::Bits16, 3, 5);
    rig.run().unwrap().file()
}

#[test]
fn every_stage_has_its_price_in_instructions() {
    let rig = rig(2500, TimerWidth::Bits32, 3, 6);
    let events = rig.run().unwrap().file();
    let bench = Bench::new("qemu_cost", &events);
    let output = bench.succeed(&[EVENTS, SLOT]);
    // What was measured is what a session does.
    assert!(bench.written(SLOT) == session::run(&events).unwrap().slot);
    for (stage, most) in [
        ("front", 200.0),
        ("learn", 200.0),
        ("correct", 130.0),
        ("angle_at", 340.0),
    ] {
        let calls = number(&output, &format!("{stage}_calls"));
        let each = number(&output, &format!("{stage}_instructions")) as f64 / calls as f64;
        println!("{stage:<9} {each:>6.1} instructions each, {calls} calls");
        assert!((10.0..most).contains(&each), "{stage}: {each}");
    }
    let solve = number(&output, "solve_instructions");
    println!("solve     {solve} instructions");
    assert!(solve < 30_000_000, "{solve}");
    bounded_slices(&output, "solve");
    assert_eq!(output.stdout, bench.succeed(&[EVENTS, SLOT]).stdout);
}

/// No slice of a piece of work may take 20,000 instructions.
fn bounded_slices(output: &Output, work: &str) {
    let of = |what: &str| number(output, &format!("{work}_{what}"));
    let (all, slices, longest) = (of("instructions"), of("slices"), of("longest"));
    println!("{work:<9} {all} instructions in {slices} slices, the longest {longest}");
    assert!(slices > 50 && longest < 20_000, "{work}: {longest}");
}

#[test]
fn no_slice_is_long_however_the_shaft_was_driven() {
    use quadcal_host_tests::anywhere::{Rig, Scenario};
    for (scenario, turns) in [(Scenario::Ramp, 58), (Scenario::OneSpeedCogging, 10)] {
        let run = Rig {
            scenario,
            lines: 2500,
        }
        .run(7)
        .unwrap();
        let (header, rows) = run.into_recordings().swap_remove(0);
        let header = Header {
            timer: TimerWidth::Bits32,
            wiring: Wiring::Quadrature,
            lines: 2500,
            clock_hz: u32::try_from(header.clock_hz).unwrap(),
            turns,
        };
        let events = events(&rows, TimerWidth::Bits32, Latency::NONE).file(&header);
        let output = Bench::new("qemu_cost", &events).succeed(&[EVENTS, SLOT]);
        println!("{scenario:?}");
        bounded_slices(&output, "solve");
        bounded_slices(&output, "look_out");
    }
}

#[test]
fn no_slice_is_long_whatever_the_encoder() {
    let folder = tempfile::tempdir().unwrap();
    let output = run_qemu(&image("qemu_slices"), &[], folder.path(), LIMIT)
        .unwrap_or_else(|error| panic!("{error}"));
    assert!(output.success, "{}", output.stderr);
    println!("{}", output.stdout);
    let longest = |key: &str| {
        let words = output.stdout.split_ascii_whitespace();
        let values = words.filter_map(|word| word.strip_prefix(key)?.parse::<u64>().ok());
        let values: Vec<u64> = values.collect();
        // Every encoder with every ride.
        assert_eq!(values.len(), 36, "{key}");
        values.into_iter().max().unwrap()
    };
    assert!(longest("solve_longest=") < 20_000);
    assert!(longest("look_out_longest=") < 20_000);
}

#[test]
fn the_edge_path_has_no_panic_no_division_and_no_float() {
    let elf = image("qemu_cost");
    for stage in ["front", "learn", "correct", "angle_at"] {
        let functions = reachable(&elf, &format!("qemu_cost::stages::{stage}"))
            .unwrap_or_else(|error| panic!("{error}"));
        let names: Vec<&str> = functions.iter().map(|f| f.name.as_str()).collect();
        let instructions: usize = functions.iter().map(|f| f.instructions.len()).sum();
        println!("{stage}: {instructions} instructions in {names:?}");
        assert!(instructions > 20);
        assert_eq!(offences(&functions), [], "{stage}");
    }
}

#[test]
fn the_fingerprint_has_no_panic_and_its_edge_path_no_division_either() {
    let elf = image("edge_cost");
    let of = |name: &str| {
        let functions = reachable(&elf, &format!("edge_cost::locate::{name}"));
        offences(&functions.unwrap_or_else(|error| panic!("{error}")))
    };
    assert_eq!(of("pushed"), []);
    let mut slice = of("fingerprint_slice");
    slice.retain(|offence| offence.what == "panics" || offence.what.starts_with('v'));
    assert_eq!(slice, []);
}

#[test]
fn draining_captures_has_no_panic_no_division_and_no_float() {
    // The STM32F405's driver, the merger and the encoder behind them.
    let drain = reachable(&image("edge_cost"), "edge_cost::captures::drain_block").unwrap();
    let instructions: usize = drain.iter().map(|f| f.instructions.len()).sum();
    assert!(instructions > 400, "{instructions}");
    assert_eq!(offences(&drain), []);
    // The whole control loop of an image, with angle and speed.
    let control = reachable(&image("drive_f405"), "SysTick").unwrap();
    assert_eq!(offences(&control), []);
}

#[test]
fn a_slice_of_search_takes_less_than_20_000_instructions() {
    let folder = tempfile::tempdir().unwrap();
    let output = run_qemu(&image("edge_cost"), &[], folder.path(), LIMIT)
        .unwrap_or_else(|error| panic!("{error}"));
    assert!(output.success, "{}", output.stderr);
    println!("{}", output.stdout);
    let words = output.stdout.replace(' ', "\n");
    let value = |key: &str| -> u64 {
        let line = words
            .lines()
            .find_map(|word| word.strip_prefix(key)?.strip_prefix('='));
        line.and_then(|value| value.parse().ok())
            .unwrap_or_else(|| panic!("{key} in {words}"))
    };
    for stage in ["weigh_slice", "search_slice"] {
        assert!(value(stage) < 20_000, "{stage}");
    }
}

#[test]
fn a_panic_and_a_division_would_be_seen() {
    let functions = reachable(&image("qemu_cost"), "main").unwrap();
    let found = offences(&functions);
    for sign in ["panics", "divides", "udiv"] {
        assert!(
            found.iter().any(|offence| offence.what.starts_with(sign)),
            "{sign} not in {found:?}"
        );
    }
    assert!(matches!(
        reachable(&image("qemu_cost"), "no::such::function"),
        Err(FirmwareError::Code { .. })
    ));
}

#[test]
fn image_names_what_is_wrong_with_its_input_and_fails() {
    let good = short();
    let mut kind = good.clone();
    kind[28] = 9;
    let mut lines = good.clone();
    lines[8] ^= 1;
    let mut wheel = good.clone();
    wheel[7] = 2;
    for (bytes, complaint) in [
        (&b"QCEV"[..], "byte 4: the file ends inside a record"),
        (&[0; 64][..], "byte 0: not an event file"),
        (&good[..10_003], "byte 9996: the file ends inside a record"),
        (&kind[..], "byte 28: kind of record 9 is not known"),
        (&lines[..], "361 lines, but memory for 1440 edges"),
        (&wheel[..], "Wheel wired, expected quadrature"),
        (&good[..20_020], "the stream ended after 0 whole turns"),
    ] {
        let bench = Bench::new("qemu_replay_360", bytes);
        let run = bench.run(&[EVENTS, SLOT, CORRECTED]);
        assert!(!run.success);
        assert!(run.stderr.contains(complaint), "{}", run.stderr);
        assert!(!bench.folder.path().join(SLOT).exists());
    }
    let run = Bench::new("qemu_replay_360", &good).run(&[EVENTS]);
    assert!(
        !run.success && run.stderr.contains("usage"),
        "{}",
        run.stderr
    );
}

#[test]
fn a_hanging_machine_is_killed_and_reported() {
    let folder = tempfile::tempdir().unwrap();
    // The guest blocks in a read of a pipe that nobody writes to.
    let pipe = folder.path().join(EVENTS);
    assert!(
        std::process::Command::new("mkfifo")
            .arg(&pipe)
            .status()
            .unwrap()
            .success()
    );
    let error = run_qemu(
        &image("qemu_replay_360"),
        &[EVENTS, SLOT, CORRECTED],
        folder.path(),
        Duration::from_secs(1),
    )
    .unwrap_err();
    assert!(
        matches!(error, FirmwareError::Hang { seconds: 1, .. }),
        "{error}"
    );
}

#[test]
fn symbols_name_the_image_s_functions() {
    let symbols = symbols(&image("qemu_cost")).unwrap();
    let main = symbols.iter().find(|symbol| symbol.name == "main").unwrap();
    assert!(main.code && main.size > 0);
    assert!(
        symbols
            .iter()
            .any(|symbol| symbol.name.ends_with("counter::WRAPS") && !symbol.code)
    );
}
