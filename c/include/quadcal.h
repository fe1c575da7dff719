/* quadcal for C. Made from the crate by `cargo test -p quadcal-c`, with QUADCAL_WRITE_HEADER=1 to write it anew.
   Licence: MIT or Apache-2.0. */

#ifndef QUADCAL_H
#define QUADCAL_H

#include <stddef.h>
#include <stdint.h>

/* Bytes of memory that quadcal_learn_start wants for an encoder of so many lines; see quadcal_learn_bytes. */
#define QUADCAL_LEARN_BYTES(lines) (24u * (lines) + 12u * 1024u)

/* Bytes of the table of an encoder of so many lines. */
#define QUADCAL_TABLE_BYTES(lines) (8u * (lines) + 164u)


// 64-bit words of a quadcal_encoder.
#define QUADCAL_ENCODER_WORDS 80

// 64-bit words of a quadcal_learner.
#define QUADCAL_LEARNER_WORDS 2016

// What a call came to. Negative values are errors: nothing was done.
enum quadcal_status
#if defined(__cplusplus) || __STDC_VERSION__ >= 202311L
  : int32_t
#endif // defined(__cplusplus) || __STDC_VERSION__ >= 202311L
 {
  // Done; of a capture: it was an edge.
  QUADCAL_OK = 0,
  // The capture was no edge: the first one, a change of Z alone, a glitch, which takes the edge before back, or no change.
  QUADCAL_NO_EDGE = 1,
  // There is more to do: call again.
  QUADCAL_MORE = 2,
  // A pointer is null or not aligned.
  QUADCAL_ERROR_POINTER = -1,
  // The structure was not initialised.
  QUADCAL_ERROR_NOT_INITIALISED = -2,
  // No lines, or more than 16,384.
  QUADCAL_ERROR_LINES = -3,
  // The glitch gate is not from 2 to 31.
  QUADCAL_ERROR_GATE = -4,
  // The timer has neither 16 nor 32 bits.
  QUADCAL_ERROR_TIMER = -5,
  // There is no edge yet that an angle could go on from.
  QUADCAL_ERROR_NO_ANGLE = -6,
  // The bytes are no table: another magic, version or length, or a field out of range.
  QUADCAL_ERROR_TABLE = -7,
  // The bytes' check sum is not the table's.
  QUADCAL_ERROR_TABLE_CRC = -8,
  // The table is of an encoder with other lines.
  QUADCAL_ERROR_TABLE_SHAPE = -9,
  // The table's delays can't be told in ticks of this clock.
  QUADCAL_ERROR_TABLE_CLOCK = -10,
  // The memory is too small.
  QUADCAL_ERROR_MEMORY = -11,
  // Fewer than two turns were taken: nothing says how well turns agree.
  QUADCAL_ERROR_TOO_FEW_TURNS = -12,
  // Not at this stage: samples after the first slice, or a table before the last one.
  QUADCAL_ERROR_STAGE = -13,
};
#ifndef __cplusplus
#if __STDC_VERSION__ >= 202311L
typedef enum quadcal_status quadcal_status;
#else
typedef int32_t quadcal_status;
#endif // __STDC_VERSION__ >= 202311L
#endif // __cplusplus

// What the encoder and the timer are.
typedef struct quadcal_config {
  // Tick rate of the timer, hertz: a table's delays are told in its ticks.
  uint64_t clock_hz;
  // Time without an edge after which the shaft stands still, ticks.
  uint64_t timeout;
  // Grating lines a turn, 1 to 16,384; a turn has four times as many edges.
  uint32_t lines;
  // Bits of the timer, which counts up and wraps: 16 or 32.
  uint32_t timer_bits;
  // A pulse shorter than the typical interval times 2^-gate is a glitch: 2 to 31, usually 3.
  uint32_t glitch_gate;
  // Levels of A and B (bit 0 and 1) in which a high Z marks line 0, usually 1.
  uint8_t index_levels;
  // 1: the encoder has an index, and a table applies once it is seen. 0: a table applies from the first edge on.
  uint8_t has_index;
} quadcal_config;

// An encoder, opaque. Set it to all zeros (a static variable is) or initialise it before any other call. Functions that take the
// same encoder must not interrupt each other: call them from interrupts of one priority, or mask those.
typedef struct quadcal_encoder {
  // Not to be touched.
  uint64_t memory[QUADCAL_ENCODER_WORDS];
} quadcal_encoder;

// One capture as the timer's interrupt finds it.
typedef struct quadcal_capture {
  // The latched counter, ticks.
  uint32_t raw;
  // Levels after the change: bit 0 is A, bit 1 is B, bit 2 is Z.
  uint8_t levels;
  // Not 0: the timer's overflow flag, read after the capture, is set.
  uint8_t overflow_pending;
} quadcal_capture;

// One edge, corrected.
typedef struct quadcal_corrected {
  // Time of the edge as captured, ticks.
  uint64_t ticks;
  // Shaft angle, 2^-32 turn. Before the index its origin is where counting began.
  uint32_t angle;
  // Angle moved since the edge before, 2^-32 turn, negative in reverse; 0 where the direction changed.
  int32_t moved;
  // Time since the edge before as captured, ticks; 0 at the first edge.
  uint32_t interval;
  // Facts about the edge, the bits of `quadcal::step::Flags`: 1 first edge, 2 reversed, 4 index known, 8 index here, 16 count
  // uncertain since the last index, 32 A and B changed together, 64 reversed without slowing down, 128 long interval before.
  uint32_t flags;
} quadcal_corrected;

// How the encoder is.
typedef struct quadcal_view {
  // Position, 0 to 4 times the lines less 1.
  uint32_t position;
  // 1 forward (A rises before B), -1 in reverse.
  int32_t direction;
  // 1 once the index was seen.
  uint32_t index_known;
  // 1 where the count may be wrong since the last index.
  uint32_t count_uncertain;
  // Changes of levels that no single edge makes. This count and all that follow saturate.
  uint32_t illegal;
  // Edges missing from the count, found at the index.
  uint32_t lost;
  // Edges too many in the count, found at the index.
  uint32_t extra;
  // Pulses shorter than the glitch gate.
  uint32_t glitch;
  // Reversals without slowing down.
  uint32_t abrupt_reversal;
  // Single intervals far too long between steady ones.
  uint32_t interval_spike;
  // Captures that change no level.
  uint32_t repeated;
} quadcal_view;

// What learns a table, opaque; large, so best a static variable. Belongs to the main loop. Set it to all zeros (a static variable is) or
// start it before any other call.
typedef struct quadcal_learner {
  // Not to be touched.
  uint64_t memory[QUADCAL_LEARNER_WORDS];
} quadcal_learner;

// One capture with its whole time, as the capture interrupt queues it.
typedef struct quadcal_sample {
  // Time, ticks, from quadcal_capture_time.
  uint64_t ticks;
  // Levels after the change: bit 0 is A, bit 1 is B, bit 2 is Z.
  uint8_t levels;
} quadcal_sample;

#ifdef __cplusplus
extern "C" {
#endif // __cplusplus

// The name of a status, as in this header; "QUADCAL_UNKNOWN" for any other number. The text is constant.
const char *quadcal_error_name(int32_t status);

// The usual settings: with an index where A is high and B low, at a standstill after 0.1 s without an edge.
struct quadcal_config quadcal_usual_config(uint32_t lines, uint32_t timer_bits, uint64_t clock_hz);

// Initialises an encoder that has seen nothing and has no table. Divides: not for an interrupt.
//
// # Safety
// Both point to such structures or are null.
quadcal_status quadcal_init(struct quadcal_encoder *encoder, const struct quadcal_config *config);

// Counts one wrap of the timer. From the overflow interrupt, together with clearing its flag, after pending captures were served.
//
// # Safety
// As said at `quadcal_encoder`.
quadcal_status quadcal_overflow(struct quadcal_encoder *encoder);

// Takes one capture, from the capture interrupt: QUADCAL_OK with the edge in `corrected`, or QUADCAL_NO_EDGE. Unless it is null,
// `speed` gets the mean speed since the edge before, 2^-60 turn a tick, forward positive, which takes twice as long.
//
// # Safety
// As said at `quadcal_encoder`; the others point to such things or are null.
quadcal_status quadcal_edge(struct quadcal_encoder *encoder,
                            const struct quadcal_capture *capture,
                            struct quadcal_corrected *corrected,
                            int64_t *speed);

// Takes captures as quadcal_edge does, in order, with no wrap of the timer between them. `corrected` has room for as many edges as
// there are captures; how many there are comes in `edges`.
//
// # Safety
// As said at `quadcal_encoder`; `captures` and `corrected` have `count` items.
quadcal_status quadcal_edges(struct quadcal_encoder *encoder,
                             const struct quadcal_capture *captures,
                             size_t count,
                             struct quadcal_corrected *corrected,
                             size_t *edges);

// Time of the counter value `counter`, read just before the overflow flag: what `quadcal_angle` and `quadcal_speed` take.
//
// # Safety
// As said at `quadcal_encoder`; `ticks` points to such a number or is null.
quadcal_status quadcal_time(struct quadcal_encoder *encoder,
                            uint32_t counter,
                            uint8_t overflow_pending,
                            uint64_t *ticks);

// Time of a capture, for the queue of `quadcal_learn_samples`.
//
// # Safety
// As said at `quadcal_encoder`; the others point to such things or are null.
quadcal_status quadcal_capture_time(struct quadcal_encoder *encoder,
                                    const struct quadcal_capture *capture,
                                    uint64_t *ticks);

// Shaft angle at the time `ticks`, 2^-32 turn: from the newest edge on at the speed of the last interval, but never past the next edge,
// which would have been seen. QUADCAL_ERROR_NO_ANGLE before the first edge. No division.
//
// # Safety
// As said at `quadcal_encoder`; `angle` points to such a number or is null.
quadcal_status quadcal_angle(struct quadcal_encoder *encoder,
                             uint64_t ticks,
                             uint32_t *angle);

// Speed at the time `ticks`, 2^-60 turn a tick, forward positive: the mean over the last interval, but no more than one step since the
// newest edge allows, and 0 after the timeout. No division. Revolutions a minute are speed * clock_hz * 60 / 2^60.
//
// # Safety
// As said at `quadcal_encoder`; `speed` points to such a number or is null.
quadcal_status quadcal_speed(struct quadcal_encoder *encoder,
                             uint64_t ticks,
                             int64_t *speed);

// Position, direction, index and faults.
//
// # Safety
// As said at `quadcal_encoder`; `view` points to such a structure or is null.
quadcal_status quadcal_state(struct quadcal_encoder *encoder, struct quadcal_view *view);

// Corrects by a table from the next edge on. Its bytes are those that quadcal_learn_table wrote, or a file's of `quadcal calibrate`;
// they are checked, and then used in place: they must stay as they are until another table is set. Not for an interrupt.
//
// # Safety
// As said at `quadcal_encoder`; `bytes` points to `length` of them, which nobody writes to from now on, or is null.
quadcal_status quadcal_set_table(struct quadcal_encoder *encoder,
                                 const uint8_t *bytes,
                                 size_t length);

// Corrects no more from the next edge on: angles are the grid's. Not for an interrupt.
//
// # Safety
// As said at `quadcal_encoder`.
quadcal_status quadcal_clear_table(struct quadcal_encoder *encoder);

// Bytes of memory that `quadcal_learn_start` wants for an encoder of so many lines, 0 for lines out of range. QUADCAL_LEARN_BYTES is the same at
// compile time, for all line counts but those whose edges have no divisor that fits.
size_t quadcal_learn_bytes(uint32_t lines);

// Starts to learn with nothing known. The memory is the learner's until it is started again; it is aligned to 4 bytes, and static
// memory or set to zero.
//
// # Safety
// As said at `quadcal_learner`; `memory` has `length` initialised bytes that nobody else uses.
quadcal_status quadcal_learn_start(struct quadcal_learner *learner,
                                   const struct quadcal_config *config,
                                   uint32_t *memory,
                                   size_t length);

// Learns from samples, in order and without a gap, all captures of A, B and Z; turns taken so far come in `turns`, unless it is null.
//
// # Safety
// As said at `quadcal_learner`; `samples` has `count` items, and `turns` is a number or null.
quadcal_status quadcal_learn_samples(struct quadcal_learner *learner,
                                     const struct quadcal_sample *samples,
                                     size_t count,
                                     uint32_t *turns);

// Solves for a part, in fewer than 20,000 instructions of a Cortex-M4: QUADCAL_MORE until the table is there, then QUADCAL_OK. From the
// first slice on samples are refused. How much is done comes in `percent`, unless it is null.
//
// # Safety
// As said at `quadcal_learner`; `percent` is a number or null.
quadcal_status quadcal_learn_slice(struct quadcal_learner *learner,
                                   uint32_t *percent);

// Writes the learned table's bytes, with their check sum, and how many they are: 164 + 8 for each line. A place in flash or RAM takes them as
// they are.
//
// # Safety
// As said at `quadcal_learner`; `bytes` has `room` initialised ones, and `length` is a number or null.
quadcal_status quadcal_learn_table(struct quadcal_learner *learner,
                                   uint8_t *bytes,
                                   size_t room,
                                   size_t *length);

#ifdef __cplusplus
}  // extern "C"
#endif  // __cplusplus

#endif  /* QUADCAL_H */
