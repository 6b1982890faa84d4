/* The plant as the model of an FMU. */
#include "model.h"

#include <math.h>
#include <stdio.h>
#include <string.h>

#include "plant.h"

#define FIRST_PARAMETER (model_ports.noise_seed)
#define PARAMETERS (1 + RISES + TUNABLE)

const bool model_clock_may_jump = false;

struct model {
    struct plant plant;
    double parameters[PARAMETERS]; /* that the plant is made of */
    bool made;
};

struct model *model_make(struct setup *setup, size_t *content_size)
{
    *content_size = sizeof(struct plant_memory);
    return setup_take(setup, 1, sizeof(struct model));
}

void model_reset(struct model *self, void *content)
{
    (void)self;
    memset(content, 0, sizeof(struct plant_memory));
}

/* Writes why a value is not allowed; a decimal comma of the host's locale becomes a point. */
static const char *refusal(size_t ref, double value, char problem[PROBLEM_LENGTH])
{
    const struct range *range = &machine_ranges[ref];
    const char *name = model_variables[ref].name;
    snprintf(
        problem, PROBLEM_LENGTH, "%.200s: %g is not allowed: it must be %g to %g%.40s", name,
        value, range->low, range->high, range->unit);
    for (char *c = problem + strlen(name); *c != '\0'; c++) {
        *c = *c == ',' ? '.' : *c;
    }
    return problem;
}

/* Returns what is wrong with the values from a reference on, NULL for nothing. */
static const char *look(
    const double *values, size_t first, size_t count, char problem[PROBLEM_LENGTH])
{
    for (size_t ref = first; ref < first + count; ref++) {
        if (!(values[ref] >= machine_ranges[ref].low && values[ref] <= machine_ranges[ref].high)) {
            return refusal(ref, values[ref], problem);
        }
    }
    return NULL;
}

static bool same_parameters(const struct model *self, const double *values)
{
    size_t size = sizeof self->parameters;
    return self->made && memcmp(self->parameters, values + FIRST_PARAMETER, size) == 0;
}

/* Makes the plant of the parameters, unless it is made of them already. */
static void make(struct model *self, const double *values)
{
    const double *parameters = values + FIRST_PARAMETER;
    if (!same_parameters(self, values)) {
        memcpy(self->parameters, parameters, sizeof self->parameters);
        /* A restored state may hold a seed that a start would refuse. */
        uint32_t seed = parameters[0] > 0.0 ? (uint32_t)parameters[0] : 0;
        plant_prepare(&self->plant, parameters + 1 + RISES, seed);
        self->made = true;
    }
}

const char *model_start(
    struct model *self, void *content, const double *values, double time_s,
    char problem[PROBLEM_LENGTH])
{
    (void)time_s;
    const char *wrong = look(values, FIRST_PARAMETER, PARAMETERS, problem);
    if (wrong == NULL) {
        wrong = look(values, 0, INPUTS + 1 + AXES, problem);
    }
    if (wrong == NULL) {
        make(self, values);
        plant_start(
            &self->plant, content, values, values + FIRST_PARAMETER + 1, values[INPUTS]);
    }
    return wrong;
}

const char *model_step(
    struct model *self, void *content, const double *values, double time_s, double step_s,
    char problem[PROBLEM_LENGTH])
{
    const char *wrong = look(values, 0, INPUTS + 1 + AXES, problem);
    (void)time_s;
    /* Parameters that have been set since the last step count from this one on. */
    if (wrong == NULL && !same_parameters(self, values)) {
        wrong = look(values, FIRST_PARAMETER, PARAMETERS, problem);
    }
    if (wrong != NULL) {
        return wrong;
    }
    make(self, values);
    return plant_step(
        &self->plant, content, step_s, values, values[INPUTS], values + INPUTS + 1);
}

void model_restored(struct model *self, const void *content, const double *values)
{
    (void)content;
    make(self, values);
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
