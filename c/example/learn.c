/* Learning on board: samples in, slices of solving, a table out. */

#include "board.h"

/* Turns to learn from. */
#define TURNS 6u

static quadcal_learner learner;
static uint32_t memory[QUADCAL_LEARN_BYTES(LINES) / 4u];
static uint8_t table[QUADCAL_TABLE_BYTES(LINES)];

/* Solving checks the bounds of its arrays. None is ever passed, but the linker can't know: what would come then is the program's. */
void quadcal_a_panic_can_be_reached(void) {
    print_word("failed: panic");
    print_end();
    leave(1);
}

void learn(const quadcal_config *config) {
    uint32_t turns = 0u, slices = 0u;
    size_t length = 0u;
    quadcal_status status;
    check("quadcal_learn_start", quadcal_learn_start(&learner, config, memory, sizeof memory));
    while (turns < TURNS) {
        quadcal_capture capture = next_capture();
        quadcal_corrected corrected;
        quadcal_sample sample;
        check("quadcal_edge", quadcal_edge(&encoder, &capture, &corrected, NULL));
        check("quadcal_capture_time", quadcal_capture_time(&encoder, &capture, &sample.ticks));
        sample.levels = capture.levels;
        check("quadcal_learn_samples", quadcal_learn_samples(&learner, &sample, 1u, &turns));
        print_word("learn");
        print_number(sample.ticks);
        print_number(sample.levels);
        print_end();
    }
    do {
        status = quadcal_learn_slice(&learner, NULL);
        check("quadcal_learn_slice", status);
        ++slices;
    } while (status == QUADCAL_MORE);
    check("quadcal_learn_table", quadcal_learn_table(&learner, table, sizeof table, &length));
    print_word("slices");
    print_number(slices);
    print_end();
    print_word("table");
    for (size_t i = 0u; i < length; ++i) {
        print_number(table[i]);
    }
    print_end();
    check("quadcal_set_table", quadcal_set_table(&encoder, table, length));
}

