/* The signals of a scenario as the model of an FMU; see the Python twin, scenarios/ssp/slave.py. */
#include "signals.h"

#include <string.h>

const bool model_clock_may_jump = false;
const struct continuous *const model_continuous = NULL;
const struct derivatives *const model_derivatives = NULL;

struct model {
    char nothing;
};

struct model *model_make(struct setup *setup, size_t *content_size)
{
    *content_size = sizeof(struct outputs);
    return setup_take(setup, 1, sizeof(struct model));
}

void model_reset(struct model *self, void *content)
{
    (void)self;
    memset(content, 0, sizeof(struct outputs));
}

/* Sets the outputs to the last row whose time is reached, or to the first row before that. */
static void show(struct outputs *outputs, double time_s)
{
    size_t low = 0, high = ROWS;
    while (high - low > 1) {
        size_t middle = low + (high - low) / 2;
        if (signals_times[middle] <= time_s) {
            low = middle;
        } else {
            high = middle;
        }
    }
    memcpy(outputs->shown, signals_values[low], sizeof outputs->shown);
}

const char *model_start(
    struct model *self, void *content, const double *values, double time_s,
    char problem[PROBLEM_LENGTH])
{
    (void)self, (void)values, (void)problem;
    show(content, time_s);
    return NULL;
}

const char *model_step(
    struct model *self, void *content, const double *values, double time_s, double step_s,
    char problem[PROBLEM_LENGTH])
{
    (void)self, (void)values, (void)problem;
    show(content, time_s + step_s + clock_slack(time_s, step_s));
    return NULL;
}

void model_text(const void *content, char text[PROBLEM_LENGTH])
{
    (void)content;
    text[0] = '\0';
}

char *model_text_parameter(void *content, size_t *size)
{
    (void)content;
    *size = 0;
    return NULL;
}
