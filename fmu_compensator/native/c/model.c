/* The compensator as the model of an FMU. */
#include "model.h"

#include <string.h>

#include "compensator.h"
#include "memory.h"
#include "numbers.h"

/* A gap in the clock is time without samples: see the Python twin, compensator.step. */
const bool model_clock_may_jump = true;
const struct continuous *const model_continuous = NULL;

struct model {
    struct compensator compensator;
};

struct model *model_make(struct setup *setup, size_t *content_size)
{
    struct model *self = setup_take(setup, 1, sizeof *self);
    if (self != NULL) {
        compensator_make(setup, &self->compensator);
        *content_size = self->compensator.size;
    }
    return self;
}

void model_reset(struct model *self, void *content)
{
    compensator_reset(&self->compensator, content);
}

const char *model_start(
    struct model *self, void *content, const double *values, double time_s,
    char problem[PROBLEM_LENGTH])
{
    (void)self, (void)values, (void)time_s, (void)problem;
    if (((const struct content *)content)->model_file[0] != '\0') {
        return "model_file: this FMU has its compensator file compiled in and reads no other; "
               "build another FMU from that file";
    }
    return NULL;
}

const char *model_step(
    struct model *self, void *content, const double *values, double time_s, double step_s,
    char problem[PROBLEM_LENGTH])
{
    struct input input = {
        time_s, step_s, values, values[model_ports.speed], values[model_ports.tool_length], NULL};
    (void)problem;
    if (values[model_ports.measured] != 0.0) {
        input.measured = values + model_ports.measured_targets;
    }
    compensator_step(&self->compensator, content, &input);
    return NULL;
}

/* The knowns are temperatures, speed and tool_length; the unknowns are the real outputs. */
static size_t place(enum side side, size_t ref)
{
    const struct variable *variable = &model_variables[ref];
    if (side == KNOWN) {
        return ref <= model_ports.tool_length ? ref : NONE;
    }
    return variable->causality == OUTPUT && variable->kind == REAL
               ? variable->offset / sizeof(double)
               : NONE;
}

/* Derivatives of the next step, if it is as long as the last one. */
static const char *derive(
    struct model *self, const void *content, const double *values, double time_s, enum side from,
    const double *seeds, double *found, char problem[PROBLEM_LENGTH])
{
    struct compensator *compensator = &self->compensator;
    const struct content *now = content;
    size_t tool = model_ports.tool_length;
    double step_s = time_s - now->last_time, tool_length = values[tool], moved[REAL_OUTPUTS];
    struct input input = {time_s, step_s, values, values[model_ports.speed], tool_length, NULL};
    size_t sensors = model_sensor_count;
    (void)problem;
    memset(found, 0, (from == KNOWN ? REAL_OUTPUTS : tool + 1) * sizeof *found);
    if (!now->started || !(step_s > 0.0)) {
        return NULL; /* The references of the rises are not known yet. */
    }
    struct content *next = memory_take(1, compensator->size + sensors * sizeof(double));
    if (next == NULL) {
        return "there is not enough memory for derivatives";
    }
    double *unit = (double *)next + compensator->size / sizeof(double);
    memcpy(next, content, compensator->size);
    compensator_step(compensator, next, &input);
    if (from == KNOWN) {
        compensator_derive(compensator, tool_length, seeds, seeds[tool], found);
    }
    for (size_t known = 0; from != KNOWN && known <= tool; known++) {
        size_t sensor = known < sensors ? known : 0;
        unit[sensor] = known < sensors;
        compensator_derive(compensator, tool_length, unit, known == tool, moved);
        unit[sensor] = 0.0;
        found[known] = dot(seeds, moved, REAL_OUTPUTS);
    }
    memory_give(next);
    return NULL;
}

const struct derivatives compensator_derivatives = {place, derive};

void model_text(const void *content, char text[PROBLEM_LENGTH])
{
    status_text(&((const struct content *)content)->output, text, PROBLEM_LENGTH);
}

char *model_text_parameter(void *content, size_t *size)
{
    *size = FILE_LENGTH;
    return ((struct content *)content)->model_file;
}
