/* What a firmware check asks of a board: to say something, to count instructions, to measure its stack, to stop. */
#ifndef BOARD_H
#define BOARD_H

#include <stdint.h>

/* Runs once the memory is set up; what it returns is the exit code. */
int checked(void);

/* Say a text, or a word in hexadecimal. */
void say(const char *text);
void say_word(uint32_t word);

/* A clock of the board. Its ticks are instructions times a factor that `calibrated` finds. */
uint32_t ticks(void);

/* Paint the free stack, and how many bytes of it were used since. */
void paint_stack(void);
uint32_t stack_used(void);

#endif
