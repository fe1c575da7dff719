//! Starts without an index, a fixed sample. `locate --starts 1000` sweeps more.
#![allow(missing_docs)]

use quadcal_host_tests::locate::{Case, Disc, End};

/// Bits asked for: wrong once in 16 million.
const BITS: u8 = 24;

/// Ends of starts spread over the turn, of two discs with their own tables or each other's.
fn ends(case: Case, swapped: bool) -> Vec<(u32, End)> {
    let discs = [Disc::new(case, 7001), Disc::new(case, 7002)];
    let start = |i: usize| {
        let (disc, table) = (&discs[i % 2], &discs[(i + usize::from(swapped)) % 2]);
        let start = disc.start(table.table(), i as f64 / 12.0, BITS);
        (start.edges, start.end)
    };
    (0..12).map(start).collect()
}

#[test]
fn the_place_is_found_within_five_degrees_and_never_a_wrong_one() {
    for case in [Case::Paper, Case::WeakPattern, Case::Cogging, Case::Ramp] {
        for (edges, end) in ends(case, false) {
            assert!(
                matches!(end, End::Right(BITS..)),
                "{}: {end:?}",
                case.name()
            );
            let degrees = f64::from(edges) * 360.0 / 10_000.0;
            assert!(degrees < 5.0, "{}: {degrees}", case.name());
        }
    }
}

#[test]
fn hard_conditions_take_longer_and_are_never_wrong() {
    for case in [Case::CoarseClock, Case::FewLines, Case::HalfJitter] {
        for (_, end) in ends(case, false) {
            assert!(
                matches!(end, End::Right(BITS..)),
                "{}: {end:?}",
                case.name()
            );
        }
    }
}

#[test]
fn another_discs_table_is_refused() {
    for case in [Case::Paper, Case::CoarseClock, Case::FewLines] {
        for (_, end) in ends(case, true) {
            assert!(
                matches!(end, End::Refused(BITS..)),
                "{}: {end:?}",
                case.name()
            );
        }
    }
}

#[test]
fn a_smooth_pattern_can_tell_nothing_and_says_so() {
    for swapped in [false, true] {
        for (_, end) in ends(Case::Smooth, swapped) {
            assert_eq!(end, End::Open { told: true });
        }
    }
}

#[test]
fn a_slipped_index_and_another_disc_are_noticed_in_use_and_nothing_else_is() {
    for case in [
        Case::Paper,
        Case::FewLines,
        Case::CoarseClock,
        Case::Cogging,
    ] {
        let [disc, other] = [7001, 7002].map(|seed| Disc::new(case, seed));
        assert_eq!(disc.watch(disc.table(), BITS), None, "{}", case.name());
        for table in [&disc.table().slipped(1), other.table()] {
            let edges = disc.watch(table, BITS).unwrap_or(u32::MAX);
            assert!(edges < 500, "{}: {edges}", case.name());
        }
    }
}
