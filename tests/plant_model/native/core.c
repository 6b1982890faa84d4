/* The plant's core as ctypes calls it. */
#include <stdlib.h>
#include <string.h>

#include "plant.h"

struct both {
    struct plant plant;
    struct plant_memory memory;
};

#define SHOWN __attribute__((visibility("default")))

SHOWN void *core_new(const double *parameters, unsigned seed)
{
    struct both *self = calloc(1, sizeof *self);
    plant_prepare(&self->plant, parameters, seed);
    return self;
}

SHOWN void core_free(void *self)
{
    free(self);
}

SHOWN void core_start(struct both *self, const double *inputs, const double *rises, double tool)
{
    plant_start(&self->plant, &self->memory, inputs, rises, tool);
}

SHOWN const char *core_step(
    struct both *self, double step, const double *inputs, double tool, const double *offsets)
{
    return plant_step(&self->plant, &self->memory, step, inputs, tool, offsets);
}

SHOWN int core_is_linear(const struct both *self)
{
    return self->plant.linear;
}

SHOWN double core_fastest(struct both *self, const double *inputs)
{
    network_at(&self->plant.network, self->plant.k, inputs);
    return self->plant.network.fastest;
}

SHOWN void core_outputs(const struct both *self, double *outputs)
{
    memcpy(outputs, self->memory.outputs, sizeof self->memory.outputs);
}
