/* What all boards share. */
#include "board.h"

void say_word(uint32_t word)
{
    char text[9];
    for (int digit = 0; digit < 8; ++digit) {
        text[digit] = "0123456789abcdef"[(word >> (28 - 4 * digit)) & 15u];
    }
    text[8] = '\0';
    say(text);
}
