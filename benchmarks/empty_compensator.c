/* Stands in for compensator.c: the same variables, and a step that does nothing. */
#include "compensator.h"

void compensator_make(struct setup *setup, struct compensator *self)
{
    (void)setup;
    self->numbers = 0;
}

void compensator_reset(
    const struct compensator *self, struct remembered *memory, double *numbers,
    struct output *output)
{
    (void)self, (void)memory, (void)numbers, (void)output;
}

void compensator_step(
    const struct compensator *self, struct remembered *memory, double *numbers,
    const struct input *input, struct output *output)
{
    (void)self, (void)memory, (void)numbers, (void)input, (void)output;
}

struct parts compensator_parts(const struct compensator *self, double *numbers)
{
    struct parts none = {0};
    (void)self, (void)numbers;
    return none;
}
