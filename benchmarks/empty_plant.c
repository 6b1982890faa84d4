/* A plant that does nothing, in the place of plant.c. */
#include "plant.h"

#include <string.h>

void plant_prepare(struct plant *self, const double *parameters, uint32_t seed)
{
    (void)parameters, (void)seed;
    memset(self, 0, sizeof *self);
}

void plant_start(
    struct plant *self, struct plant_memory *memory, const double *inputs, const double *rises,
    double tool_length)
{
    (void)self, (void)inputs, (void)rises, (void)tool_length;
    memset(memory, 0, sizeof *memory);
}

void plant_show(
    const struct plant *self, struct plant_memory *memory, const double *inputs,
    double tool_length)
{
    (void)self, (void)memory, (void)inputs, (void)tool_length;
}

const char *plant_rates(
    struct plant *self, const struct plant_memory *memory, const double *inputs,
    double rates[SIZE])
{
    (void)self, (void)memory, (void)inputs;
    memset(rates, 0, SIZE * sizeof *rates);
    return NULL;
}

void plant_go_on(struct plant_memory *memory, double step_s, const double offsets[AXES])
{
    (void)memory, (void)step_s, (void)offsets;
}

const char *plant_step(
    struct plant *self, struct plant_memory *memory, double step_s, const double *inputs,
    double tool_length, const double offsets[AXES])
{
    (void)self, (void)memory, (void)step_s, (void)inputs, (void)tool_length, (void)offsets;
    return NULL;
}
