use super::*;
use crate::edge::Levels;
use crate::estimate::StaticBuffers;
use crate::replay::Header;
use crate::replay::corrected::CorrectedFile;
use std::vec::Vec;

const HEADER: Header = Header {
    timer: TimerWidth::Bits16,
    wiring: Wiring::Quadrature,
    lines: 8,
    clock_hz: 1000,
    turns: 3,
};

/// A perfect encoder of eight lines at 1000 ticks an edge; the index is high within edge 0's sector.
fn file(header: Header, edges: u32) -> Vec<u8> {
    let mut bytes = header.emit().to_vec();
    let mut put = |event: Event| bytes.extend(event.emit());
    for k in 0..edges {
        let z = if k % 32 == 0 { 4 } else { 0 };
        let ticks = 1000 * (k + 1);
        if ticks >> 16 != (ticks - 1000) >> 16 {
            put(Event::Overflow);
        }
        put(Event::Capture {
            raw: ticks & 0xFFFF,
            levels: Levels([1, 3, 2, 0][k as usize % 4] | z),
            overflow_pending: false,
        });
    }
    bytes
}

type Written = (Vec<u8>, Vec<u8>);

fn session(bytes: &[u8]) -> Result<(Report, Written), SessionError<()>> {
    let mut rest = bytes;
    let source = |block: &mut [u8]| {
        let (now, later) = rest.split_at(block.len().min(rest.len()));
        block[..now.len()].copy_from_slice(now);
        rest = later;
        Ok(now.len())
    };
    let (mut slot, mut corrected) = (Vec::new(), Vec::new());
    let sink = |part, bytes: &[u8]| {
        match part {
            Part::Slot => slot.extend_from_slice(bytes),
            Part::Corrected => corrected.extend_from_slice(bytes),
        }
        Ok(())
    };
    let report = run(source, &mut [0; 80], StaticBuffers::<8, 4>::new(), sink)?;
    Ok((report, (slot, corrected)))
}

#[test]
fn what_follows_the_last_turn_learned_is_corrected() {
    // Edge 0 of turn 1 is the first after the index; the first turn gives the rate alone.
    let (report, (slot, corrected)) = session(&file(HEADER, 6 * 32)).unwrap();
    assert_eq!(report.learned.turns, 3);
    let slot = slot::Slot::parse(&slot).unwrap();
    assert_eq!(slot.header.turns, 3);
    let learned_until = slot.header.learned_until;
    let file = CorrectedFile::parse(&corrected).unwrap();
    assert_eq!(file.edges().len(), report.corrected as usize);
    assert_eq!(file.edges().next().unwrap().ticks, learned_until + 1000);
    assert_eq!(file.edges().last().unwrap().ticks, 6 * 32 * 1000);
    assert!(file.edges().all(|edge| edge.moved.0 == 1 << 27));
    assert_eq!(file.faults.total(), 0);
}

#[test]
fn a_stream_that_does_not_suit_is_refused_before_anything_is_written() {
    let whole = file(HEADER, 6 * 32);
    let hall = Header {
        wiring: Wiring::Hall,
        ..HEADER
    };
    let nine = Header { lines: 9, ..HEADER };
    let one = Header { turns: 1, ..HEADER };
    assert_eq!(
        session(&file(hall, 192)).err(),
        Some(SessionError::Wiring(Wiring::Hall))
    );
    assert_eq!(
        session(&file(nine, 192)).err(),
        Some(SessionError::Lines {
            wanted: 9,
            edges: 32
        })
    );
    assert_eq!(
        session(&file(one, 192)).err(),
        Some(SessionError::Solve(SolveError::TooFewTurns(1)))
    );
    assert!(matches!(
        session(&whole[..800]),
        Err(SessionError::Read(ReadError::Truncated { .. }))
    ));
    assert!(matches!(
        session(&file(HEADER, 100)),
        Err(SessionError::TooFewTurns(totals)) if totals.turns < 3
    ));
}

#[test]
fn a_table_learned_before_corrects_the_whole_stream() {
    let bytes = file(HEADER, 6 * 32);
    let (_, (learned, rest)) = session(&bytes).unwrap();
    let slot = Slot::parse(&learned).unwrap();
    let with = |mut file: &[u8]| {
        let mut corrected = Vec::new();
        let source = |block: &mut [u8]| {
            let (now, later) = file.split_at(block.len().min(file.len()));
            block[..now.len()].copy_from_slice(now);
            file = later;
            Ok::<usize, ()>(now.len())
        };
        let sink = |bytes: &[u8]| {
            corrected.extend_from_slice(bytes);
            Ok(())
        };
        correct(source, &mut [0; 80], &slot, sink).map(|edges| (edges, corrected))
    };
    let (edges, whole) = with(&bytes).unwrap();
    let (whole, rest) = (
        CorrectedFile::parse(&whole).unwrap(),
        CorrectedFile::parse(&rest).unwrap(),
    );
    // The first sample tells the levels.
    assert_eq!(edges, 6 * 32 - 1);
    assert_eq!(whole.edges().len(), edges as usize);
    // The first edge after learning has none before it.
    let later = whole.edges().skip(edges as usize - rest.edges().len() + 1);
    assert!(later.eq(rest.edges().skip(1)));
    let nine = file(Header { lines: 9, ..HEADER }, 192);
    let wrong = SessionError::Lines {
        wanted: 9,
        edges: 32,
    };
    assert_eq!(with(&nine).err(), Some(wrong));
}
