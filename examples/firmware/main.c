/* The firmware: every millisecond the controller sees the state and pushes the cart; the plant is simulated beside it by the
 * emitted step. Every fifty milliseconds a line is said: time in ms, cart in um, both angles off upright in urad, force in mN. */
#include "board.h"
#include "plant.h"
#include "plant_controller.h"

#define STEPS 2000
#define EVERY 50

static void say_number(int32_t number)
{
    char text[13];
    int place = 12;
    uint32_t left = number < 0 ? 0u - (uint32_t)number : (uint32_t)number;

    text[place] = '\0';
    do {
        text[--place] = (char)('0' + left % 10u);
        left /= 10u;
    } while (left > 0u);
    if (number < 0) {
        text[--place] = '-';
    }
    say(" ");
    say(&text[place]);
}

/* In millionths, or thousandths, to the nearest. */
static int32_t parts(float value, float unit)
{
    return (int32_t)(value * unit + (value < 0.0F ? -0.5F : 0.5F));
}

int checked(void)
{
    /* Both links lean away from upright, in opposite ways. */
    float state[2 * PLANT_NQ] = {0.0F, 3.1415927F + 0.06F, -0.03F, 0.0F, 0.0F, 0.0F};
    float next[2 * PLANT_NQ], force[PLANT_NU];

    for (int step = 0; step <= STEPS; ++step) {
        plant_controller(state, force);
        if (step % EVERY == 0) {
            say_number(step);
            say_number(parts(state[0], 1e6F));
            say_number(parts(state[1] - 3.1415927F, 1e6F));
            say_number(parts(state[2], 1e6F));
            say_number(parts(force[0], 1e3F));
            say("\n");
        }
        plant_step(0.001F, state, state + PLANT_NQ, force, next, next + PLANT_NQ);
        for (int i = 0; i < 2 * PLANT_NQ; ++i) {
            state[i] = next[i];
        }
    }
    return 0;
}
