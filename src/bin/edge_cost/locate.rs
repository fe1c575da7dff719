//! The fingerprint: what an edge costs, and the longest slice of each stage of the search, on an encoder that the table is not of,
//! so that every stage is gone through.

use core::hint::black_box;

use cortex_m_semihosting::hprintln;
use quadcal::decoder::{DecoderConfig, QuadratureDecoder};
use quadcal::edge::{Levels, Sample};
use quadcal::fingerprint::{Fingerprint, FingerprintConfig, Trail, Verdict};
use quadcal::shape::{CLASSES_MAX, EncoderShape};
use quadcal::step::Outcome;
use quadcal::table::ErrorTable;
use quadcal::units::TurnDelta32;

use super::counter::InstructionCounter;
use super::rig::{BLOCK, LINES, Rig, SLOTS};

/// Blocks of a window.
const BLOCKS: usize = 4;

/// Half blocks of the table in a slice.
const SLICE: u32 = 96;

/// Errors up to 12 % of a step.
static ENTRIES: [i16; SLOTS as usize] = entries();

const fn entries() -> [i16; SLOTS as usize] {
    let mut entries = [0; SLOTS as usize];
    let (mut i, mut random) = (0, 7_u32);
    while i < entries.len() {
        random = random.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
        entries[i] = (random >> 16) as i16;
        i += 1;
    }
    entries
}

/// Prints everything; `None` if the rig does not fit the core.
pub fn measure(counter: &InstructionCounter, samples: &mut [Sample; BLOCK]) -> Option<()> {
    let shape = EncoderShape::new(SLOTS, 4).ok()?;
    let table = ErrorTable::new(shape, [TurnDelta32(0); CLASSES_MAX], &ENTRIES, 0).ok()?;
    let mut fingerprint: Fingerprint<'_, BLOCKS> =
        Fingerprint::new(table, FingerprintConfig::new(1000)).ok()?;
    let mut trail = Trail::<128>::new();
    let (mut weighing, mut slices) = (0, 0);
    while fingerprint_slice(counter, &mut fingerprint, &trail, &mut weighing) == Verdict::Searching
    {
        slices += 1;
    }
    hprintln!("weigh_slice={} weigh_slices={}", weighing, slices);

    let mut decoder = QuadratureDecoder::new(DecoderConfig::new(LINES)).ok()?;
    let mut rig = Rig::new();
    let (mut pushing, mut empty, mut edges) = (0, 0, 0_u64);
    let (mut longest, mut slices, mut windows) = (0, 0_u64, 0_u64);
    let mut last = Verdict::Gathering;
    for _ in 0..40 {
        rig.fill(samples);
        for sample in samples.iter() {
            let levels = Levels(sample.levels.0 & (Levels::A | Levels::B));
            let outcome = decoder.push(Sample { levels, ..*sample });
            let begin = counter.now();
            nothing(black_box(&outcome));
            let middle = counter.now();
            pushed(&mut trail, black_box(&outcome));
            pushing += counter.now() - middle;
            empty += middle - begin;
            edges += 1;
        }
        loop {
            let verdict = fingerprint_slice(counter, &mut fingerprint, &trail, &mut longest);
            slices += u64::from(verdict == Verdict::Searching);
            windows += u64::from(verdict != last && verdict == Verdict::Searching);
            last = verdict;
            if verdict != Verdict::Searching {
                break;
            }
        }
    }
    let tenths = (pushing - empty) * 10 / edges;
    hprintln!("trail={}.{}", tenths / 10, tenths % 10);
    hprintln!(
        "search_slice={} slices_a_window={}",
        longest,
        slices / windows.max(1)
    );
    hprintln!(
        "trail_bytes={} fingerprint_bytes={}",
        size_of_val(&trail),
        size_of_val(&fingerprint)
    );
    matches!(last, Verdict::OtherDisc(_)).then_some(())
}

#[inline(never)]
fn nothing(outcome: &Outcome) {
    black_box(outcome);
}

#[inline(never)]
fn pushed(trail: &mut Trail<128>, outcome: &Outcome) {
    trail.push(outcome);
    black_box(trail);
}

#[inline(never)]
fn fingerprint_slice(
    counter: &InstructionCounter,
    fingerprint: &mut Fingerprint<'_, BLOCKS>,
    trail: &Trail<128>,
    longest: &mut u64,
) -> Verdict {
    let begin = counter.now();
    let verdict = fingerprint.search(trail, SLICE);
    *longest = (*longest).max(counter.now() - begin);
    verdict
}
