/* Start-up and semihosting. */

#include "board.h"

extern uint32_t data_begin, data_end, data_stored, bss_begin, bss_end, stack_top;

static void reset(void);
static void fault(void);

__attribute__((section(".vectors"), used)) const struct {
    uint32_t *stack;
    void (*handlers[15])(void);
} vectors = {&stack_top, {reset, fault, fault, fault, fault, fault}};

static long semihosting(long call, const void *argument) {
    register long r0 __asm__("r0") = call;
    register const void *r1 __asm__("r1") = argument;
    __asm__ volatile("bkpt 0xAB" : "+r"(r0) : "r"(r1) : "memory");
    return r0;
}

static char line[512];
static uint32_t used;
/* Whether a word stands in the line. */
static int begun;

static void flush(void) {
    static const char console[] = ":tt";
    static long handle = -1;
    if (handle < 0) {
        /* SYS_OPEN of the console, to write. */
        const uintptr_t open[3] = {(uintptr_t)console, 4u, sizeof console - 1u};
        handle = semihosting(0x01, open);
    }
    /* SYS_WRITE. */
    const uintptr_t write[3] = {(uintptr_t)handle, (uintptr_t)line, used};
    (void)semihosting(0x05, write);
    used = 0;
}

static void put(char c) {
    if (used == sizeof line) {
        flush();
    }
    line[used++] = c;
}

void print_word(const char *word) {
    if (begun) {
        put(' ');
    }
    begun = 1;
    while (*word != 0) {
        put(*word++);
    }
}

void print_number(uint64_t number) {
    char digits[21];
    uint32_t at = sizeof digits - 1u;
    digits[at] = 0;
    do {
        digits[--at] = (char)('0' + number % 10u);
        number /= 10u;
    } while (number != 0u);
    print_word(&digits[at]);
}

void print_end(void) {
    put('\n');
    flush();
    begun = 0;
}

void leave(int code) {
    /* SYS_EXIT: the application's end, or a run-time error. */
    (void)semihosting(0x18, (const void *)(code == 0 ? 0x20026L : 0x20023L));
    for (;;) {
    }
}

static void fault(void) {
    print_word("fault");
    print_end();
    leave(1);
}

static void reset(void) {
    uint32_t *from = &data_stored;
    for (uint32_t *to = &data_begin; to < &data_end;) {
        *to++ = *from++;
    }
    for (uint32_t *to = &bss_begin; to < &bss_end;) {
        *to++ = 0;
    }
    /* The library is built for the floating-point unit's calling convention. */
    *(volatile uint32_t *)0xE000ED88u |= 0xFu << 20;
    __asm__ volatile("dsb\n isb");
    leave(main());
}
