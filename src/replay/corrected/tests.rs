use super::*;
use proptest::prelude::*;
use std::vec::Vec;

const HEADER: CorrectedHeader = CorrectedHeader {
    lines: 2500,
    clock_hz: 84_000_000,
};

const FAULTS: Faults = Faults {
    illegal: 1,
    lost: 2,
    extra: 3,
    glitch: 4,
    abrupt_reversal: 5,
    interval_spike: 6,
    repeated: u32::MAX,
    missed: 0,
};

fn file(edges: &[CorrectedEdge]) -> Vec<u8> {
    let mut bytes = HEADER.emit().to_vec();
    edges.iter().for_each(|edge| bytes.extend(emit_edge(edge)));
    bytes.extend(emit_faults(&FAULTS));
    bytes
}

#[test]
fn bytes_stand_where_the_format_says() {
    let edge = CorrectedEdge {
        ticks: 0x0102_0304_0506_0708,
        angle: Turn32(0x1112_1314),
        moved: TurnDelta32(-2),
        interval: 0x2122_2324,
        late: TickDelta8(-3),
        stretch: TickDelta8(0x4142_4344),
        flags: Flags(0x3132),
    };
    let bytes = file(&[edge]);
    assert_eq!(&bytes[..8], b"QCCE\x02\0\0\0");
    assert_eq!(bytes[8..16], [0xc4, 0x09, 0, 0, 0x00, 0xbd, 0x01, 0x05]);
    assert_eq!(bytes[16..24], [8, 7, 6, 5, 4, 3, 2, 1]);
    assert_eq!(bytes[24..28], [0x14, 0x13, 0x12, 0x11]);
    assert_eq!(bytes[28..32], [0xfe, 0xff, 0xff, 0xff]);
    assert_eq!(
        bytes[32..40],
        [0x24, 0x23, 0x22, 0x21, 0xfd, 0xff, 0xff, 0xff]
    );
    assert_eq!(bytes[40..48], [0x44, 0x43, 0x42, 0x41, 0x32, 0x31, 0, 0]);
    assert_eq!(bytes[48..56], [1, 0, 0, 0, 2, 0, 0, 0]);
    assert_eq!(bytes.len(), 76);
}

#[test]
fn a_file_is_refused_with_what_is_wrong() {
    let edge = CorrectedEdge {
        ticks: 0,
        angle: Turn32(0),
        moved: TurnDelta32(0),
        interval: 0,
        late: TickDelta8::ZERO,
        stretch: TickDelta8::ZERO,
        flags: Flags::NONE,
    };
    let good = file(&[edge, edge]);
    let with = |at: usize, value| {
        let mut bytes = good.clone();
        bytes[at] = value;
        CorrectedFile::parse(&bytes).unwrap_err()
    };
    assert_eq!(with(0, b'X'), CorrectedError::Magic);
    assert_eq!(with(4, 9), CorrectedError::Version(9));
    assert_eq!(with(7, 1), CorrectedError::Reserved(6));
    assert_eq!(with(78, 1), CorrectedError::Reserved(78));
    for cut in [0, 15, 43, 53, good.len() - 1] {
        let error = CorrectedFile::parse(&good[..cut]).unwrap_err();
        assert_eq!(error, CorrectedError::Length(cut));
    }
}

proptest! {
    #[test]
    fn any_edges_come_back_from_the_file(
        values in prop::collection::vec(any::<(u64, u32, i32, u32, i32, i32, u16)>(), 0..20),
    ) {
        let edges: Vec<CorrectedEdge> = values
            .into_iter()
            .map(|(ticks, angle, moved, interval, late, stretch, flags)| CorrectedEdge {
                ticks,
                angle: Turn32(angle),
                moved: TurnDelta32(moved),
                interval,
                late: TickDelta8(late),
                stretch: TickDelta8(stretch),
                flags: Flags(flags),
            })
            .collect();
        let bytes = file(&edges);
        let back = CorrectedFile::parse(&bytes).unwrap();
        prop_assert_eq!((back.header, back.faults), (HEADER, FAULTS));
        prop_assert_eq!(back.edges().collect::<Vec<_>>(), edges);
    }
}
