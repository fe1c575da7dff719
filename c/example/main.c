/* quadcal in a bare C program: captures of an encoder of 90 lines in, angle and speed out. With LEARN its errors are learned too,
   and the table is used. The captures come from a pretended shaft in place of a timer. Runs in QEMU: qemu-system-arm
   -M netduinoplus2 -nographic -semihosting-config enable=on,target=native -kernel build/learn.elf */

#include "board.h"

/* Turns to correct in each direction. */
#define TURNS 2u

quadcal_encoder encoder;

/* The pretended shaft: 600 r/min, each edge up to an eighth of a step out of place, on a timer of 16 bits. */
static uint32_t edge = EDGES / 2u;
static uint64_t grid;
static int backward;
static uint32_t wraps;

static int32_t error_of(uint32_t number) {
    uint32_t random = (number + 1u) * 2654435761u;
    random = (random ^ random >> 15) * 2246822519u;
    return (int32_t)((random >> 16) % 5833u) - 2916;
}

/* The next capture; counts the overflows that are due before it. */
quadcal_capture next_capture(void) {
    static const uint8_t levels[4] = {1, 3, 2, 0};
    quadcal_capture capture;
    uint32_t position, crossed;
    uint64_t ticks;
    grid += 23333u;
    if (backward) {
        crossed = edge;
        edge = edge == 0u ? EDGES - 1u : edge - 1u;
    } else {
        edge = edge + 1u == EDGES ? 0u : edge + 1u;
        crossed = edge;
    }
    position = edge;
    ticks = grid + (uint64_t)(int64_t)(backward ? -error_of(crossed) : error_of(crossed));
    while (wraps < ticks >> 16) {
        ++wraps;
        check("quadcal_overflow", quadcal_overflow(&encoder));
    }
    capture.raw = (uint32_t)(ticks & 0xFFFFu);
    capture.overflow_pending = 0u;
    capture.levels = levels[position % 4u] | (position == 0u ? 4u : 0u);
    return capture;
}

/* What a capture interrupt does, and what the control loop asks some time later. */
static void serve(void) {
    quadcal_capture capture = next_capture();
    quadcal_corrected corrected = {0};
    int64_t speed = 0, speed_now = 0;
    uint64_t ticks = 0;
    uint32_t angle_now = 0;
    quadcal_status status = quadcal_edge(&encoder, &capture, &corrected, &speed);
    check("quadcal_edge", status);
    check("quadcal_capture_time", quadcal_capture_time(&encoder, &capture, &ticks));
    (void)quadcal_angle(&encoder, ticks + 9000u, &angle_now);
    check("quadcal_speed", quadcal_speed(&encoder, ticks + 9000u, &speed_now));
    print_word("edge");
    print_number(ticks);
    print_number(capture.levels);
    print_number((uint64_t)(int64_t)status);
    print_number(corrected.angle);
    print_number(corrected.interval);
    print_number((uint64_t)speed);
    print_number(angle_now);
    print_number((uint64_t)speed_now);
    print_end();
}

int main(void) {
    quadcal_config config = quadcal_usual_config(LINES, 16u, CLOCK_HZ);
    quadcal_view view;
    quadcal_status status = quadcal_clear_table(&encoder);
    print_word(quadcal_error_name(status));
    print_end();
    check("quadcal_init", quadcal_init(&encoder, &config));
    for (uint32_t i = 0u; i < 2u * EDGES; ++i) {
        serve();
    }
#ifdef LEARN
    learn(&config);
#endif
    for (uint32_t i = 0u; i < TURNS * EDGES; ++i) {
        serve();
    }
    backward = 1;
    for (uint32_t i = 0u; i < TURNS * EDGES; ++i) {
        serve();
    }
    check("quadcal_state", quadcal_state(&encoder, &view));
    print_word("state");
    print_number(view.position);
    print_number((uint64_t)(int64_t)view.direction);
    print_number(view.index_known);
    print_number(view.count_uncertain);
    print_number(view.lost + view.extra + view.illegal + view.glitch);
    print_end();
    return 0;
}

/* Ends the program at an error, with its name. */
void check(const char *call, quadcal_status status) {
    if (status < 0) {
        print_word("failed:");
        print_word(call);
        print_word(quadcal_error_name(status));
        print_end();
        leave(1);
    }
}
