/* The compensator as the model of an FMU. */
#include "model.h"

#include <string.h>

#include "content.h"
#include "model_data.h"
#include "texts.h"

/* A gap in the clock is time without a sample: see the Python twin, compensator.step. */
const bool model_clock_may_jump = true;
const struct continuous *const model_continuous = NULL;

struct model *model_make(struct setup *setup, size_t *content_size)
{
    struct model *self = setup_take(setup, 1, sizeof *self);
    if (self != NULL) {
        compensator_make(setup, &self->compensator);
        *content_size =
            sizeof(struct content) + self->compensator.numbers * sizeof(double);
    }
    return self;
}

void model_reset(struct model *self, void *content)
{
    struct content *all = content;
    compensator_reset(&self->compensator, &all->remembered, all->numbers, &all->output);
}

const char *model_start(
    struct model *self, void *content, const double *values, double time_s,
    char problem[PROBLEM_LENGTH])
{
    struct content *all = content;
    (void)self, (void)values, (void)time_s, (void)problem;
    if (all->model_file[0] != '\0') {
        return "model_file: this FMU has its compensator file compiled in and reads no other; "
               "build another FMU from that file";
    }
    return NULL;
}

const char *model_step(
    struct model *self, void *content, const double *values, double time_s, double step_s,
    char problem[PROBLEM_LENGTH])
{
    struct content *all = content;
    struct input input = {time_s, step_s, values, 0.0, 0.0, NULL};
    (void)problem;
    input.speed = values[model_ports.speed];
    input.tool_length = values[model_ports.tool_length];
    if (values[model_ports.measured] != 0.0) {
        input.measured = values + model_ports.measured_targets;
    }
    compensator_step(&self->compensator, &all->remembered, all->numbers, &input, &all->output);
    return NULL;
}

void model_restored(struct model *self, const void *content, const double *values)
{
    (void)self, (void)content, (void)values;
}

void model_text(const void *content, char text[PROBLEM_LENGTH])
{
    const struct content *all = content;
    status_text(&all->output, text, PROBLEM_LENGTH);
}

char *model_text_parameter(void *content, size_t *size)
{
    struct content *all = content;
    *size = FILE_LENGTH;
    return all->model_file;
}
