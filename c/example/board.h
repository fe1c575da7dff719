/* What the example needs of an STM32F405 in QEMU: start-up, output, an end; and what its parts share. */
#ifndef BOARD_H
#define BOARD_H

#include <stdint.h>

#include "quadcal.h"

#define LINES 90u
#define EDGES (4u * LINES)
#define CLOCK_HZ 84000000u

int main(void);

extern quadcal_encoder encoder;

/* The next capture of the pretended shaft. */
quadcal_capture next_capture(void);

/* Learns a table and puts it to use. */
void learn(const quadcal_config *config);

/* A word, a number in decimal, the end of a line. */
void print_word(const char *word);
void print_number(uint64_t number);
void print_end(void);

/* Ends the run. */
void leave(int code);

/* Ends it with the name of an error, if there is one. */
void check(const char *call, quadcal_status status);

#endif
