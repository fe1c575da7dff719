use super::*;
use proptest::prelude::*;

const HEADER: Header = Header {
    timer: TimerWidth::Bits16,
    wiring: Wiring::Hall,
    lines: 2500,
    clock_hz: 84_000_000,
    turns: 11,
};

fn with(index: usize, value: u8) -> Result<Header, ReplayError> {
    let mut bytes = HEADER.emit();
    bytes[index] = value;
    Header::parse(&bytes)
}

#[test]
fn header_bytes_stand_where_the_format_says() {
    let bytes = HEADER.emit();
    assert_eq!(&bytes[..8], b"QCEV\x01\x00\x10\x01");
    assert_eq!(
        bytes[8..],
        [0xc4, 0x09, 0, 0, 0x00, 0xbd, 0x01, 0x05, 11, 0, 0, 0]
    );
    assert_eq!(Header::parse(&bytes), Ok(HEADER));
}

#[test]
fn header_is_refused_with_the_value_that_is_wrong() {
    assert_eq!(with(0, b'X'), Err(ReplayError::Magic));
    assert_eq!(with(4, 2), Err(ReplayError::Version(2)));
    assert_eq!(with(6, 24), Err(ReplayError::TimerBits(24)));
    assert_eq!(with(7, 4), Err(ReplayError::Wiring(4)));
    let no_lines = Header { lines: 0, ..HEADER };
    assert_eq!(Header::parse(&no_lines.emit()), Err(ReplayError::NoLines));
    let no_clock = Header {
        clock_hz: 0,
        ..HEADER
    };
    assert_eq!(Header::parse(&no_clock.emit()), Err(ReplayError::NoClock));
}

#[test]
fn record_is_refused_with_the_value_that_is_wrong() {
    let parse = |bytes| Event::parse(&bytes, TimerWidth::Bits16);
    assert_eq!(parse([2, 0, 0, 0, 0, 0, 0, 0]), Err(ReplayError::Kind(2)));
    assert_eq!(parse([0, 8, 0, 0, 0, 0, 0, 0]), Err(ReplayError::Levels(8)));
    assert_eq!(parse([0, 0, 2, 0, 0, 0, 0, 0]), Err(ReplayError::Flags(2)));
    assert_eq!(parse([0, 0, 0, 9, 0, 0, 0, 0]), Err(ReplayError::Flags(9)));
    assert_eq!(
        parse([0, 0, 0, 0, 0, 0, 1, 0]),
        Err(ReplayError::Count(65_536))
    );
    assert_eq!(parse([1, 0, 0, 0, 5, 0, 0, 0]), Err(ReplayError::Count(5)));
    assert_eq!(
        Event::parse(&[0, 0, 0, 0, 0, 0, 1, 0], TimerWidth::Bits32),
        Ok(Event::Capture {
            raw: 65_536,
            levels: Levels(0),
            overflow_pending: false
        })
    );
}

proptest! {
    #[test]
    fn any_record_that_parses_emits_its_own_bytes(bytes: [u8; RECORD_LEN]) {
        for timer in [TimerWidth::Bits16, TimerWidth::Bits32] {
            if let Ok(event) = Event::parse(&bytes, timer) {
                prop_assert_eq!(event.emit(), bytes);
            }
        }
    }

    #[test]
    fn any_capture_survives_the_way_out_and_in(raw: u32, levels in 0_u8..8, overflow_pending: bool) {
        let event = Event::Capture { raw, levels: Levels(levels), overflow_pending };
        prop_assert_eq!(Event::parse(&event.emit(), TimerWidth::Bits32), Ok(event));
    }

    #[test]
    fn any_header_that_parses_emits_its_own_bytes(tail: [u8; 14], bits in prop::sample::select(&[16_u8, 32][..])) {
        let mut bytes = HEADER.emit();
        bytes[6] = bits;
        bytes[7] = tail[0] % 4;
        bytes[8..].copy_from_slice(&tail[2..]);
        if let Ok(header) = Header::parse(&bytes) {
            prop_assert_eq!(header.emit(), bytes);
        }
    }
}
