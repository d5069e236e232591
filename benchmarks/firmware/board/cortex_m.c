/* The core of Cortex-M boards: vectors, memory, the floating point unit, semihosting, the system tick. */
#include "board.h"

extern uint32_t data_from[], data_start[], data_end[], bss_start[], bss_end[], stack_top[];

void reset(void);
static void stuck(void);

__attribute__((section(".vectors"), used)) static void *const vectors[16] = {
    stack_top, (void *)reset, (void *)stuck, (void *)stuck, (void *)stuck, (void *)stuck, (void *)stuck,
};

static int asked(int operation, const void *argument)
{
    register int r0 __asm__("r0") = operation;
    register const void *r1 __asm__("r1") = argument;
    __asm__ volatile("bkpt 0xab" : "+r"(r0) : "r"(r1) : "memory");
    return r0;
}

static void stop(uint32_t code)
{
    const uint32_t words[2] = {0x20026u, code};
    (void)asked(0x20, words);
    for (;;) {
    }
}

static void stuck(void)
{
    say("fault\n");
    stop(99);
}

void reset(void)
{
    const uint32_t *from = data_from;
    for (uint32_t *to = data_start; to < data_end; ++to) {
        *to = *from++;
    }
    for (uint32_t *to = bss_start; to < bss_end; ++to) {
        *to = 0;
    }
#ifdef BOARD_FPU
    *(volatile uint32_t *)0xE000ED88u |= 0xFu << 20;
    __asm__ volatile("dsb\n\tisb");
#endif
    *(volatile uint32_t *)0xE000E014u = 0x00FFFFFFu; /* SysTick: reload, current, the core's clock */
    *(volatile uint32_t *)0xE000E018u = 0;
    *(volatile uint32_t *)0xE000E010u = 5;
    stop((uint32_t)checked());
}

uint32_t ticks(void)
{
    return 0x00FFFFFFu - *(volatile uint32_t *)0xE000E018u;
}

void say(const char *text)
{
    (void)asked(4, text);
}

static uint32_t *here(void)
{
    uint32_t *sp;
    __asm__ volatile("mov %0, sp" : "=r"(sp));
    return sp;
}

static uint32_t *painted_to;

__attribute__((noinline)) void paint_stack(void)
{
    painted_to = here();
    for (volatile uint32_t *word = bss_end; word < painted_to; ++word) {
        *word = 0xA5A5A5A5u;
    }
}

__attribute__((noinline)) uint32_t stack_used(void)
{
    const uint32_t *word = bss_end;
    while (word < painted_to && *word == 0xA5A5A5A5u) {
        ++word;
    }
    return (uint32_t)(painted_to - word) * 4u;
}
