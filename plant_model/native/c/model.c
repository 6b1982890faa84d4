/* The plant as the model of an FMU. */
#include "model.h"

#include <math.h>
#include <stdio.h>
#include <string.h>

#include "plant.h"

#define FIRST_PARAMETER (model_ports.noise_seed)
#define PARAMETERS (1 + RISES + TUNABLE)
#define GIVEN (INPUTS + 1 + AXES) /* inputs, tool_length, offsets */

const bool model_clock_may_jump = false;

struct model {
    struct plant plant;
    double parameters[PARAMETERS]; /* those of the plant */
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

/* Writes why a value is not allowed, with a point for a decimal comma of the host's locale. */
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

/* Returns NULL, or what is wrong with the values from a reference on. */
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

/* Makes the plant from the parameters, unless it already has them. */
static void make(struct model *self, const double *values)
{
    const double *parameters = values + FIRST_PARAMETER;
    if (!same_parameters(self, values)) {
        memcpy(self->parameters, parameters, sizeof self->parameters);
        plant_prepare(&self->plant, parameters + 1 + RISES, (uint32_t)parameters[0]);
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
        wrong = look(values, 0, GIVEN, problem);
    }
    if (wrong == NULL) {
        make(self, values);
        struct plant_memory *memory = content;
        plant_start(
            &self->plant, memory, values, values + FIRST_PARAMETER + 1, values[INPUTS]);
        memory->began_s = time_s;
    }
    return wrong;
}

/* Makes the plant match the values in force, including newly set parameters. Returns NULL or an
   error message. */
static const char *ready(struct model *self, const double *values, char problem[PROBLEM_LENGTH])
{
    const char *wrong = look(values, 0, GIVEN, problem);
    if (wrong == NULL && !same_parameters(self, values)) {
        wrong = look(values, FIRST_PARAMETER, PARAMETERS, problem);
    }
    if (wrong == NULL) {
        make(self, values);
    }
    return wrong;
}

const char *model_step(
    struct model *self, void *content, const double *values, double time_s, double step_s,
    char problem[PROBLEM_LENGTH])
{
    const char *wrong = ready(self, values, problem);
    (void)time_s;
    return wrong != NULL
               ? wrong
               : plant_step(
                   &self->plant, content, step_s, values, values[INPUTS], values + INPUTS + 1);
}

static const char *rates(
    struct model *self, const void *content, const double *values, double *rates_of,
    char problem[PROBLEM_LENGTH])
{
    const char *wrong = ready(self, values, problem);
    return wrong != NULL ? wrong : plant_rates(&self->plant, content, values, rates_of);
}

static const char *show(
    struct model *self, void *content, const double *values, double time_s,
    char problem[PROBLEM_LENGTH])
{
    struct plant_memory *memory = content;
    const char *wrong = ready(self, values, problem);
    if (wrong == NULL) {
        memory->time_s = time_s - memory->began_s;
        plant_show(&self->plant, memory, values, values[INPUTS]);
    }
    return wrong;
}

static const char *complete(
    struct model *self, void *content, const double *values, double time_s,
    char problem[PROBLEM_LENGTH])
{
    struct plant_memory *memory = content;
    const char *wrong = ready(self, values, problem);
    double now = time_s - memory->began_s;
    if (wrong == NULL && now > memory->completed_s) {
        plant_go_on(memory, now - memory->completed_s, values + INPUTS + 1);
        memory->completed_s = now;
    }
    return wrong;
}

#ifdef NO_HEAP /* a controller does not need them */
const struct derivatives *const model_derivatives = NULL;
#else
/* The knowns are inputs, then states, then parameters; the unknowns rates, then outputs. */
static size_t place(enum side side, size_t ref)
{
    const struct variable *variable = &model_variables[ref];
    size_t outputs = offsetof(struct plant_memory, outputs);
    size_t states = offsetof(struct plant_memory, temperatures), offset = variable->offset;
    if (side == KNOWN) {
        bool is_state = variable->causality == OUTPUT && offset < outputs;
        size_t first_tuned = FIRST_PARAMETER + 1 + RISES;
        bool is_tuned = ref >= first_tuned && ref < first_tuned + TUNABLE;
        return ref < GIVEN ? ref
               : is_state  ? GIVEN + (offset - states) / sizeof(double)
               : is_tuned  ? GIVEN + SIZE + ref - first_tuned
                           : NONE;
    }
    if (variable->causality == DERIVATIVE) {
        return offset;
    }
    return variable->causality == OUTPUT && offset >= outputs
               ? SIZE + (offset - outputs) / sizeof(double)
               : NONE;
}

static const char *derive(
    struct model *self, const void *content, const double *values, double time_s, enum side from,
    const double *seeds, double *found, char problem[PROBLEM_LENGTH])
{
    (void)time_s;
    const struct plant_memory *memory = content;
    const double at[] = {memory->time_s, values[INPUTS]};
    const char *wrong = ready(self, values, problem);
    if (wrong == NULL) {
        (from == KNOWN ? equations_forward : equations_backward)(
            self->plant.k, values, memory->temperatures, memory->states, memory->start, at, seeds,
            found);
    }
    size_t count = from == KNOWN ? SIZE + OUTPUTS : GIVEN + SIZE + TUNABLE;
    for (size_t i = 0; wrong == NULL && i < count; i++) {
        wrong = isfinite(found[i]) ? NULL : "a derivative is not finite";
    }
    return wrong;
}

static const struct derivatives derivatives = {place, derive};
const struct derivatives *const model_derivatives = CONTINUOUS ? &derivatives : NULL;
#endif

static const struct continuous continuous = {
    SIZE, offsetof(struct plant_memory, temperatures), machine_nominals, rates, show, complete};
const struct continuous *const model_continuous = CONTINUOUS ? &continuous : NULL;

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
