/* The host as a board: no clock and no painted stack. */
#include "board.h"

#include <stdio.h>

int main(void)
{
    return checked();
}

uint32_t ticks(void)
{
    return 0;
}

void say(const char *text)
{
    (void)fputs(text, stdout);
}

void paint_stack(void)
{
}

uint32_t stack_used(void)
{
    return 0;
}
