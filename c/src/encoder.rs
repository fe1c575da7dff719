//! Captures in, corrected angle and speed out: [`quadcal::encoder`].

use quadcal::decoder::DecoderConfig;
use quadcal::edge::{Direction, Levels, Sample};
use quadcal::encoder::{Encoder, EncoderConfig};
use quadcal::estimate::Anchor;
use quadcal::slot::Slot;
use quadcal::timebase::Timebase16;
use quadcal::units::Ticks;

use crate::memory::{fits, give, held, hold, items, items_mut, status};
use crate::quadcal_status;
use crate::quadcal_status::*;

/// 64-bit words of a quadcal_encoder.
pub const QUADCAL_ENCODER_WORDS: usize = 80;

/// An encoder, opaque. Set it to all zeros (a static variable is) or initialise it before any other call. Functions that take the
/// same encoder must not interrupt each other: call them from interrupts of one priority, or mask those.
#[repr(C)]
pub struct quadcal_encoder {
    /// Not to be touched.
    pub memory: [u64; QUADCAL_ENCODER_WORDS],
}

/// What the encoder and the timer are.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct quadcal_config {
    /// Tick rate of the timer, hertz: a table's delays are told in its ticks.
    pub clock_hz: u64,
    /// Time without an edge after which the shaft stands still, ticks.
    pub timeout: u64,
    /// Grating lines a turn, 1 to 16,384; a turn has four times as many edges.
    pub lines: u32,
    /// Bits of the timer, which counts up and wraps: 16 or 32.
    pub timer_bits: u32,
    /// A pulse shorter than the typical interval times 2^-gate is a glitch: 2 to 31, usually 3.
    pub glitch_gate: u32,
    /// Levels of A and B (bit 0 and 1) in which a high Z marks line 0, usually 1.
    pub index_levels: u8,
    /// 1: the encoder has an index, and a table applies once it is seen. 0: a table applies from the first edge on.
    pub has_index: u8,
}

/// One capture as the timer's interrupt finds it.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct quadcal_capture {
    /// The latched counter, ticks.
    pub raw: u32,
    /// Levels after the change: bit 0 is A, bit 1 is B, bit 2 is Z.
    pub levels: u8,
    /// Not 0: the timer's overflow flag, read after the capture, is set.
    pub overflow_pending: u8,
}

/// One edge, corrected.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct quadcal_corrected {
    /// Time of the edge as captured, ticks.
    pub ticks: u64,
    /// Shaft angle, 2^-32 turn. Before the index its origin is where counting began.
    pub angle: u32,
    /// Angle moved since the edge before, 2^-32 turn, negative in reverse; 0 where the direction changed.
    pub moved: i32,
    /// Time since the edge before as captured, ticks; 0 at the first edge.
    pub interval: u32,
    /// Facts about the edge, the bits of `quadcal::step::Flags`: 1 first edge, 2 reversed, 4 index known, 8 index here, 16 count
    /// uncertain since the last index, 32 A and B changed together, 64 reversed without slowing down, 128 long interval before.
    pub flags: u32,
}

/// How the encoder is.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct quadcal_view {
    /// Position, 0 to 4 times the lines less 1.
    pub position: u32,
    /// 1 forward (A rises before B), -1 in reverse.
    pub direction: i32,
    /// 1 once the index was seen.
    pub index_known: u32,
    /// 1 where the count may be wrong since the last index.
    pub count_uncertain: u32,
    /// Changes of levels that no single edge makes. This count and all that follow saturate.
    pub illegal: u32,
    /// Edges missing from the count, found at the index.
    pub lost: u32,
    /// Edges too many in the count, found at the index.
    pub extra: u32,
    /// Pulses shorter than the glitch gate.
    pub glitch: u32,
    /// Reversals without slowing down.
    pub abrupt_reversal: u32,
    /// Single intervals far too long between steady ones.
    pub interval_spike: u32,
    /// Captures that change no level.
    pub repeated: u32,
}

/// What stands behind a [`quadcal_encoder`].
pub(crate) struct State {
    encoder: Encoder<'static, [u8; 2], 32>,
    /// In place of the encoder's own, for a timer of 16 bits.
    narrow: Option<Timebase16>,
    clock_hz: u64,
}

const _: () = fits::<State, quadcal_encoder>();

impl quadcal_config {
    pub(crate) fn of_encoder(&self) -> EncoderConfig {
        EncoderConfig {
            decoder: DecoderConfig {
                lines: self.lines,
                index_state: Levels(self.index_levels),
                glitch_gate: self.glitch_gate,
            },
            anchor: if self.has_index != 0 {
                Anchor::Index
            } else {
                Anchor::FirstEdge
            },
            timeout: self.timeout,
        }
    }
}

impl State {
    #[inline]
    fn time(&self, counter: u32, pending: u8) -> Ticks {
        match &self.narrow {
            Some(narrow) => narrow.now(counter, pending != 0),
            None => self.encoder.time(counter, pending != 0),
        }
    }

    #[inline]
    fn sample(&self, capture: &quadcal_capture) -> Sample {
        // Captures are served before overflows, so that a capture's time is that of a counter that shows it.
        Sample {
            ticks: self.time(capture.raw, capture.overflow_pending),
            levels: Levels(capture.levels),
        }
    }
}

/// The usual settings: with an index where A is high and B low, at a standstill after 0.1 s without an edge.
#[unsafe(no_mangle)]
pub extern "C" fn quadcal_usual_config(
    lines: u32,
    timer_bits: u32,
    clock_hz: u64,
) -> quadcal_config {
    quadcal_config {
        clock_hz,
        timeout: clock_hz / 10,
        lines,
        timer_bits,
        glitch_gate: 3,
        index_levels: Levels::A,
        has_index: 1,
    }
}

/// Initialises an encoder that has seen nothing and has no table. Divides: not for an interrupt.
///
/// # Safety
/// Both point to such structures or are null.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn quadcal_init(
    encoder: *mut quadcal_encoder,
    config: *const quadcal_config,
) -> quadcal_status {
    let init = || {
        // SAFETY: the caller's word, passed on.
        let config = unsafe { items(config, 1) }?;
        let [config] = config else {
            return Err(QUADCAL_ERROR_POINTER);
        };
        let narrow = match config.timer_bits {
            16 => Some(Timebase16::new()),
            32 => None,
            _ => return Err(QUADCAL_ERROR_TIMER),
        };
        let state = State {
            encoder: Encoder::new(config.of_encoder(), None)?,
            narrow,
            clock_hz: config.clock_hz,
        };
        // SAFETY: the caller's word, passed on; that it fits is checked above.
        unsafe { hold(encoder, state) }?;
        Ok(QUADCAL_OK)
    };
    status(init())
}

/// Counts one wrap of the timer. From the overflow interrupt, together with clearing its flag, after pending captures were served.
///
/// # Safety
/// As said at `quadcal_encoder`.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn quadcal_overflow(encoder: *mut quadcal_encoder) -> quadcal_status {
    // SAFETY: the caller's word, passed on.
    match unsafe { held::<State, _>(encoder) } {
        Ok(state) => {
            match &mut state.narrow {
                Some(narrow) => narrow.overflow(),
                None => state.encoder.overflow(),
            }
            QUADCAL_OK
        }
        Err(error) => error,
    }
}

/// Takes one capture, from the capture interrupt: QUADCAL_OK with the edge in `corrected`, or QUADCAL_NO_EDGE. Unless it is null,
/// `speed` gets the mean speed since the edge before, 2^-60 turn a tick, forward positive, which takes twice as long.
///
/// # Safety
/// As said at `quadcal_encoder`; the others point to such things or are null.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn quadcal_edge(
    encoder: *mut quadcal_encoder,
    capture: *const quadcal_capture,
    corrected: *mut quadcal_corrected,
    speed: *mut i64,
) -> quadcal_status {
    let take = || {
        // SAFETY: the caller's word, passed on.
        let state = unsafe { held::<State, _>(encoder) }?;
        // SAFETY: as before.
        let [capture] = unsafe { items(capture, 1) }? else {
            return Err(QUADCAL_ERROR_POINTER);
        };
        if corrected.is_null() {
            return Err(QUADCAL_ERROR_POINTER);
        }
        let sample = state.sample(capture);
        let Some(seen) = state.encoder.edge_at(sample) else {
            return Ok(QUADCAL_NO_EDGE);
        };
        // SAFETY: as before.
        unsafe { give(corrected, of_edge(&seen.edge)) }?;
        if !speed.is_null() {
            // SAFETY: as before.
            unsafe { give(speed, seen.speed().0) }?;
        }
        Ok(QUADCAL_OK)
    };
    status(take())
}

#[inline]
fn of_edge(edge: &quadcal::corrector::CorrectedEdge) -> quadcal_corrected {
    quadcal_corrected {
        ticks: edge.ticks,
        angle: edge.angle.0,
        moved: edge.moved.0,
        interval: edge.interval,
        flags: u32::from(edge.flags.0),
    }
}

/// Takes captures as quadcal_edge does, in order, with no wrap of the timer between them. `corrected` has room for as many edges as
/// there are captures; how many there are comes in `edges`.
///
/// # Safety
/// As said at `quadcal_encoder`; `captures` and `corrected` have `count` items.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn quadcal_edges(
    encoder: *mut quadcal_encoder,
    captures: *const quadcal_capture,
    count: usize,
    corrected: *mut quadcal_corrected,
    edges: *mut usize,
) -> quadcal_status {
    let take = || {
        // SAFETY: the caller's word, passed on, here and below.
        let state = unsafe { held::<State, _>(encoder) }?;
        let captures = unsafe { items(captures, count) }?;
        let mut places = unsafe { items_mut(corrected, count) }?.iter_mut();
        if edges.is_null() {
            return Err(QUADCAL_ERROR_POINTER);
        }
        let mut found = 0;
        for capture in captures {
            let sample = state.sample(capture);
            if let Some(seen) = state.encoder.edge_at(sample)
                && let Some(place) = places.next()
            {
                *place = of_edge(&seen.edge);
                found += 1;
            }
        }
        unsafe { give(edges, found) }?;
        Ok(QUADCAL_OK)
    };
    status(take())
}

/// Time of the counter value `counter`, read just before the overflow flag: what `quadcal_angle` and `quadcal_speed` take.
///
/// # Safety
/// As said at `quadcal_encoder`; `ticks` points to such a number or is null.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn quadcal_time(
    encoder: *mut quadcal_encoder,
    counter: u32,
    overflow_pending: u8,
    ticks: *mut u64,
) -> quadcal_status {
    // SAFETY: the caller's word, passed on.
    let told = unsafe { held::<State, _>(encoder) }
        .and_then(|state| unsafe { give(ticks, state.time(counter, overflow_pending)) });
    status(told.map(|()| QUADCAL_OK))
}

/// Time of a capture, for the queue of `quadcal_learn_samples`.
///
/// # Safety
/// As said at `quadcal_encoder`; the others point to such things or are null.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn quadcal_capture_time(
    encoder: *mut quadcal_encoder,
    capture: *const quadcal_capture,
    ticks: *mut u64,
) -> quadcal_status {
    // SAFETY: the caller's word, passed on.
    match unsafe { items(capture, 1) } {
        Ok([capture]) => unsafe {
            quadcal_time(encoder, capture.raw, capture.overflow_pending, ticks)
        },
        _ => QUADCAL_ERROR_POINTER,
    }
}

/// Shaft angle at the time `ticks`, 2^-32 turn: from the newest edge on at the speed of the last interval, but never past the next edge,
/// which would have been seen. QUADCAL_ERROR_NO_ANGLE before the first edge. No division.
///
/// # Safety
/// As said at `quadcal_encoder`; `angle` points to such a number or is null.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn quadcal_angle(
    encoder: *mut quadcal_encoder,
    ticks: u64,
    angle: *mut u32,
) -> quadcal_status {
    let tell = || {
        // SAFETY: the caller's word, passed on, here and below.
        let state = unsafe { held::<State, _>(encoder) }?;
        let now = state.encoder.now(ticks).ok_or(QUADCAL_ERROR_NO_ANGLE)?;
        unsafe { give(angle, now.0) }?;
        Ok(QUADCAL_OK)
    };
    status(tell())
}

/// Speed at the time `ticks`, 2^-60 turn a tick, forward positive: the mean over the last interval, but no more than one step since the
/// newest edge allows, and 0 after the timeout. No division. Revolutions a minute are speed * clock_hz * 60 / 2^60.
///
/// # Safety
/// As said at `quadcal_encoder`; `speed` points to such a number or is null.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn quadcal_speed(
    encoder: *mut quadcal_encoder,
    ticks: u64,
    speed: *mut i64,
) -> quadcal_status {
    // SAFETY: the caller's word, passed on.
    let told = unsafe { held::<State, _>(encoder) }
        .and_then(|state| unsafe { give(speed, state.encoder.speed_at(ticks).0) });
    status(told.map(|()| QUADCAL_OK))
}

/// Position, direction, index and faults.
///
/// # Safety
/// As said at `quadcal_encoder`; `view` points to such a structure or is null.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn quadcal_state(
    encoder: *mut quadcal_encoder,
    view: *mut quadcal_view,
) -> quadcal_status {
    let tell = || {
        // SAFETY: the caller's word, passed on, here and below.
        let state = unsafe { held::<State, _>(encoder) }?;
        let (decoder, faults) = (state.encoder.decoder(), state.encoder.faults());
        let seen = quadcal_view {
            position: decoder.position(),
            direction: match decoder.direction() {
                Direction::Forward => 1,
                Direction::Reverse => -1,
            },
            index_known: decoder.is_referenced().into(),
            count_uncertain: decoder.is_uncertain().into(),
            illegal: faults.illegal,
            lost: faults.lost,
            extra: faults.extra,
            glitch: faults.glitch,
            abrupt_reversal: faults.abrupt_reversal,
            interval_spike: faults.interval_spike,
            repeated: faults.repeated,
        };
        unsafe { give(view, seen) }?;
        Ok(QUADCAL_OK)
    };
    status(tell())
}

/// Corrects by a table from the next edge on. Its bytes are those that quadcal_learn_table wrote, or a file's of `quadcal calibrate`;
/// they are checked, and then used in place: they must stay as they are until another table is set. Not for an interrupt.
///
/// # Safety
/// As said at `quadcal_encoder`; `bytes` points to `length` of them, which nobody writes to from now on, or is null.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn quadcal_set_table(
    encoder: *mut quadcal_encoder,
    bytes: *const u8,
    length: usize,
) -> quadcal_status {
    let set = || {
        // SAFETY: the caller's word, passed on, here and below.
        let state = unsafe { held::<State, _>(encoder) }?;
        let bytes: &'static [u8] = unsafe { items(bytes, length) }?;
        let slot = Slot::parse(bytes)?;
        let table = slot
            .table_at(state.clock_hz)
            .map_err(|_| QUADCAL_ERROR_TABLE_CLOCK)?;
        state.encoder.set_table(Some(table))?;
        Ok(QUADCAL_OK)
    };
    status(set())
}

/// Corrects no more from the next edge on: angles are the grid's. Not for an interrupt.
///
/// # Safety
/// As said at `quadcal_encoder`.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn quadcal_clear_table(encoder: *mut quadcal_encoder) -> quadcal_status {
    let clear = || {
        // SAFETY: the caller's word, passed on.
        let state = unsafe { held::<State, _>(encoder) }?;
        state.encoder.set_table(None)?;
        Ok(QUADCAL_OK)
    };
    status(clear())
}
