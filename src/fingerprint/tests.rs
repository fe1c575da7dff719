//! The search on edges of an even shaft, its verdicts over a drive's life, and any stream of outcomes.

use super::*;
use crate::corrector::Corrector;
use crate::decoder::{DecoderConfig, QuadratureDecoder};
use crate::edge::{Direction, Levels, Sample};
use crate::estimate::Anchor;
use crate::shape::{CLASSES_MAX, EncoderShape};
use crate::step::{Flags, Glitch, Outcome, Reference, Step};
use crate::units::TurnDelta32;
use proptest::prelude::*;
use std::vec::Vec;

const LINES: u32 = 200;
const SLOTS: u32 = 4 * LINES;
const STEP_TICKS: u64 = 1000;
/// Entries of 2^14 are a tenth of a step.
const SHIFT: u32 = 5;

/// Errors of an edge each, a tenth of a step at the most.
fn disc(seed: u32) -> Vec<i16> {
    let mut random = seed;
    let mut next = || {
        random = random.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
        (random >> 17) as i16 - (1 << 14)
    };
    (0..SLOTS).map(|_| next()).collect()
}

fn table(entries: &[i16]) -> ErrorTable<'_> {
    let shape = EncoderShape::new(SLOTS, 4).unwrap();
    ErrorTable::new(shape, [TurnDelta32(0); CLASSES_MAX], entries, SHIFT).unwrap()
}

fn search(entries: &[i16]) -> Fingerprint<'_, 4> {
    Fingerprint::new(table(entries), FingerprintConfig::new(1000)).unwrap()
}

/// An encoder on an even shaft, and the drive behind it.
struct Drive {
    disc: Vec<i16>,
    /// The sector that the shaft is in.
    place: u32,
    ticks: u64,
    /// Where Z is high; none if it is cut off.
    index: Option<u32>,
    decoder: QuadratureDecoder,
    trail: Trail<128>,
}

impl Drive {
    fn new(disc: &[i16], place: u32) -> Self {
        Self {
            disc: disc.to_vec(),
            place,
            ticks: 1 << 40,
            index: None,
            decoder: QuadratureDecoder::new(DecoderConfig::new(LINES)).unwrap(),
            trail: Trail::new(),
        }
    }

    /// One edge on.
    fn step(&mut self, direction: Direction) -> Outcome {
        self.ticks += STEP_TICKS;
        let (edge, sign) = match direction {
            Direction::Forward => ((self.place + 1) % SLOTS, 1),
            Direction::Reverse => (self.place, -1),
        };
        self.place = match direction {
            Direction::Forward => edge,
            Direction::Reverse => (self.place + SLOTS - 1) % SLOTS,
        };
        // The edge comes early by its error going forward, late going back; and some noise.
        let noise = (self.ticks / STEP_TICKS).wrapping_mul(2_654_435_761) >> 7 & 3;
        let early = i64::from(self.disc[edge as usize]) * 1000 / 163_840 * sign;
        let state = [Levels::A, Levels::A | Levels::B, Levels::B, 0][self.place as usize % 4];
        let z = if self.index == Some(self.place) {
            Levels::Z
        } else {
            0
        };
        let outcome = self.decoder.push(Sample {
            ticks: self.ticks.saturating_add_signed(-early) + noise,
            levels: Levels(state | z),
        });
        self.trail.push(&outcome);
        outcome
    }

    /// Edges until a verdict is one of those waited for, three turns at the most.
    fn until(
        &mut self,
        direction: Direction,
        fingerprint: &mut Fingerprint<'_, 4>,
        wanted: impl Fn(Verdict) -> bool,
    ) -> (u32, Verdict) {
        let mut verdict = Verdict::Gathering;
        for edges in 1..3 * SLOTS {
            self.step(direction);
            verdict = fingerprint.search(&self.trail, 10_000);
            if wanted(verdict) {
                return (edges, verdict);
            }
        }
        panic!("still {verdict:?}");
    }

    /// Lets the fingerprint find the place and tells the decoder.
    fn locate(&mut self, fingerprint: &mut Fingerprint<'_, 4>) {
        let found = |verdict| matches!(verdict, Verdict::Found(_));
        let (_, verdict) = self.until(Direction::Forward, fingerprint, found);
        let Verdict::Found(place) = verdict else {
            unreachable!()
        };
        assert!(self.decoder.locate(place.offset));
        assert!(!self.decoder.locate(place.offset));
    }
}

#[test]
fn the_place_is_found_from_a_window_in_both_directions_from_everywhere() {
    let disc = disc(3);
    for direction in [Direction::Forward, Direction::Reverse] {
        for place in (0..SLOTS).step_by(7) {
            let mut drive = Drive::new(&disc, place);
            let mut fingerprint = search(&disc);
            let decided = |verdict| !matches!(verdict, Verdict::Gathering | Verdict::Searching);
            let (edges, verdict) = drive.until(direction, &mut fingerprint, decided);
            let Verdict::Found(found) = verdict else {
                panic!("{verdict:?} at {place}")
            };
            assert_eq!(
                (drive.decoder.position() + found.offset) % SLOTS,
                drive.place
            );
            assert!(edges < 72, "{edges}");
            assert!(found.doubt >= Doubt(24), "{found:?}");
        }
    }
}

#[test]
fn another_discs_table_is_refused_and_stays_so_until_restarted() {
    let (own, other) = (disc(3), disc(4));
    let mut drive = Drive::new(&own, 77);
    let mut fingerprint = search(&other);
    let decided = |verdict| matches!(verdict, Verdict::Found(_) | Verdict::OtherDisc(_));
    let (_, verdict) = drive.until(Direction::Forward, &mut fingerprint, decided);
    assert!(
        matches!(verdict, Verdict::OtherDisc(doubt) if doubt >= Doubt(24)),
        "{verdict:?}"
    );
    drive.step(Direction::Reverse);
    assert_eq!(fingerprint.search(&drive.trail, 100), verdict);
    fingerprint.restart();
    assert_eq!(fingerprint.search(&drive.trail, 100), Verdict::Gathering);
}

#[test]
fn a_smooth_table_and_one_below_its_own_error_are_undecidable() {
    let smooth: Vec<i16> = (0..SLOTS)
        .map(|k| {
            (30_000.0 * (f64::from(k) * core::f64::consts::TAU / f64::from(SLOTS)).sin()) as i16
        })
        .collect();
    let undecidable = |verdict| verdict == Verdict::Undecidable;
    let mut drive = Drive::new(&smooth, 5);
    drive.until(Direction::Forward, &mut search(&smooth), undecidable);
    let disc = disc(5);
    let config = FingerprintConfig::new(1 << 19);
    let mut unsure: Fingerprint<'_, 4> = Fingerprint::new(table(&disc), config).unwrap();
    Drive::new(&disc, 5).until(Direction::Forward, &mut unsure, undecidable);
}

#[test]
fn tables_that_are_no_fingerprint_are_refused() {
    let entries = [0_i16; 120];
    let config = FingerprintConfig::new(0);
    let error = |edges: u32, classes, config| {
        let shape = EncoderShape::new(edges, classes).unwrap();
        let entries = &entries[..edges as usize];
        let table = ErrorTable::new(shape, [TurnDelta32(0); CLASSES_MAX], entries, 0).unwrap();
        Fingerprint::<4>::new(table, config).err()
    };
    assert_eq!(error(120, 6, config), Some(FingerprintError::Classes(6)));
    assert_eq!(error(60, 4, config), Some(FingerprintError::Edges(60)));
    assert_eq!(error(120, 4, config), None);
    let config = FingerprintConfig { bits: 61, ..config };
    assert_eq!(error(120, 4, config), Some(FingerprintError::Bits(61)));
}

#[test]
fn an_index_that_agrees_changes_nothing() {
    let disc = disc(3);
    let mut drive = Drive::new(&disc, 77);
    let mut fingerprint = search(&disc);
    drive.locate(&mut fingerprint);
    drive.index = Some(0);
    let mut corrector = Corrector::new(table(&disc), Anchor::Index);
    let fits = |verdict| verdict == Verdict::Fits;
    drive.until(Direction::Forward, &mut fingerprint, fits);
    for _ in 0..2 * SLOTS {
        let outcome = drive.step(Direction::Forward);
        corrector.push(&outcome);
        let step = outcome.step().unwrap();
        assert_eq!((step.edge, step.resync), (drive.place, 0));
        assert!(step.flags.contains(Flags::REFERENCED));
        assert_eq!(fingerprint.search(&drive.trail, 100), Verdict::Fits);
    }
    assert!(!drive.decoder.is_uncertain() && drive.decoder.faults().total() == 0);
    assert!(!corrector.is_released());
    let error = table(&disc).angle(drive.place, true);
    assert_eq!(corrector.last().unwrap().angle, error);
}

#[test]
fn an_index_that_disagrees_makes_the_corrector_give_the_table_up() {
    let disc = disc(3);
    let mut drive = Drive::new(&disc, 77);
    drive.locate(&mut search(&disc));
    drive.index = Some(40);
    let mut corrector = Corrector::new(table(&disc), Anchor::Index);
    for (until, released) in [(39, false), (300, true)] {
        while drive.place != until {
            let outcome = drive.step(Direction::Forward);
            corrector.push(&outcome);
        }
        assert_eq!(corrector.is_released(), released);
    }
    let grid = table(&[0; SLOTS as usize]).angle(drive.decoder.position(), true);
    assert_eq!(corrector.last().unwrap().angle, grid);
}

#[test]
fn a_slipped_index_and_an_exchanged_disc_are_noticed_in_operation() {
    let own = disc(3);
    let mut drive = Drive::new(&own, 790);
    drive.index = Some(0);
    let mut fingerprint = search(&own);
    drive.until(Direction::Forward, &mut fingerprint, |v| v == Verdict::Fits);
    // The disc slips by 12 edges against index and count.
    drive.disc.rotate_left(12);
    let misfit = |verdict| matches!(verdict, Verdict::Misfit(_));
    let (edges, _) = drive.until(Direction::Forward, &mut fingerprint, misfit);
    assert!(edges < 400, "{edges}");
    let found = |verdict| matches!(verdict, Verdict::Found(_));
    let (_, verdict) = drive.until(Direction::Forward, &mut fingerprint, found);
    assert!(
        matches!(verdict, Verdict::Found(place) if place.offset == 12),
        "{verdict:?}"
    );
    drive.disc = disc(4);
    drive.until(Direction::Forward, &mut fingerprint, misfit);
    let refused = |verdict| matches!(verdict, Verdict::OtherDisc(_));
    drive.until(Direction::Forward, &mut fingerprint, refused);
}

#[test]
fn a_reversal_or_a_glitch_starts_the_window_anew() {
    let disc = disc(3);
    let mut drive = Drive::new(&disc, 77);
    let mut fingerprint = search(&disc);
    for direction in [Direction::Forward, Direction::Reverse, Direction::Forward] {
        for _ in 0..60 {
            drive.step(direction);
            let verdict = fingerprint.search(&drive.trail, 10_000);
            assert!(matches!(verdict, Verdict::Gathering | Verdict::Searching));
        }
    }
    drive.trail.push(&Outcome::Glitch(Glitch {
        ticks: 0,
        edge: 0,
        position: 0,
    }));
    assert_eq!(drive.trail.count(), 0);
}

#[test]
fn slices_of_any_length_end_in_the_same_place() {
    let disc = disc(6);
    let mut drive = Drive::new(&disc, 500);
    for _ in 0..80 {
        drive.step(Direction::Reverse);
    }
    let ends: Vec<Verdict> = [1, 7, 100, 100_000]
        .into_iter()
        .map(|budget| {
            let mut fingerprint = search(&disc);
            (0..10_000)
                .map(|_| fingerprint.search(&drive.trail, budget))
                .find(|verdict| matches!(verdict, Verdict::Found(_)))
                .unwrap()
        })
        .collect();
    assert!(ends.iter().all(|end| *end == ends[0]), "{ends:?}");
}

proptest! {
    #[test]
    fn any_stream_of_outcomes_and_any_table_give_a_verdict(
        entries in prop::collection::vec(any::<i16>(), 120), shift in 0_u32..=16, standard_error in any::<u32>(), noisy in any::<bool>(),
        stream in prop::collection::vec((any::<u32>(), any::<u16>(), any::<bool>(), 0_u8..40, any::<u16>()), 1..400)
    ) {
        let shape = EncoderShape::new(120, 4).unwrap();
        let table = ErrorTable::new(shape, [TurnDelta32(0); CLASSES_MAX], &entries, shift).unwrap();
        let mut fingerprint: Fingerprint<'_, 2> =
            Fingerprint::new(table, FingerprintConfig { standard_error, bits: 1 }).unwrap();
        let mut trail = Trail::<64>::new();
        for (i, (interval, flags, forward, kind, advance)) in (0..).zip(stream) {
            let direction = if forward && noisy { Direction::Reverse } else { Direction::Forward };
            let flags = if kind < 4 { Flags(flags) } else { Flags::NONE };
            let outcome = match kind {
                0 => Outcome::Glitch(Glitch { ticks: 0, edge: 0, position: 0 }),
                1 => Outcome::Index(Reference { ticks: 0, position: 0, resync: i32::from(advance), flags }),
                _ => Outcome::Step(Step {
                    ticks: 0, edge: i % 120, position: i % 120, interval: interval >> (kind % 32), resync: 0,
                    advance: if noisy { advance } else { 1 }, flags, direction,
                }),
            };
            trail.push(&outcome);
            fingerprint.search(&trail, 50);
        }
    }
}
