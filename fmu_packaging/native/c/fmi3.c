/* FMI 3.0 in front of an instance. */
#include "fmi3Functions.h"

#include <stdio.h>
#include <string.h>

#include "instance.h"
#include "memory.h"
#include "model.h"

struct component {
    struct instance *instance;
    fmi3InstanceEnvironment environment;
    fmi3LogMessageCallback log;
    unsigned logged; /* categories */
};

static fmi3Status said(
    const struct component *self, fmi3Status status, const char *about, const char *text)
{
    char message[2 * PROBLEM_LENGTH];
    enum category category = status == fmi3Discard ? DISCARDED : REFUSED;
    if (self != NULL && (self->logged >> category & 1u) && self->log != NULL) {
        snprintf(message, sizeof message, "%s%s", about, text);
        self->log(self->environment, status, category_names[category], message);
    }
    return status;
}

#define FMI(name) fmi3##name
#define FMI_INSTANCE fmi3Instance
#define FMI_STATE(before, after) fmi3##before##FMUState##after
#define FMI_STATE_OF_BYTES fmi3DeserializeFMUState

#include "calls.h"

#define ELEMENTS(ref) ((ref) == model_array.first ? model_array.count : 1)

static bool without(
    const struct component *self, const fmi3ValueReference refs[], const void *values,
    size_t count, size_t value_count)
{
    if (incomplete(self, count == 0 || (refs != NULL && values != NULL) ? self : NULL)) {
        return true;
    }
    size_t wanted = 0;
    for (size_t i = 0; i < count; i++) {
        wanted += ELEMENTS(refs[i]);
    }
    const char *problem = "there are not as many values as value references";
    return outcome(self, wanted != value_count ? problem : NULL) != fmi3OK;
}

const char *fmi3GetVersion(void)
{
    return fmi3Version;
}

/* Returns an instance, unless there is a problem with the request. */
static fmi3Instance instantiated(
    fmi3String token, fmi3InstanceEnvironment environment, fmi3LogMessageCallback log,
    bool exchange, const char *problem)
{
    struct component *self = memory_take(1, sizeof *self);
    if (self == NULL) {
        return NULL;
    }
    self->environment = environment;
    self->log = log;
    self->logged = ~0u; /* as in FMI 2.0: every message is the reason of a refusal */
    self->instance = instance_new();
    if (problem == NULL && (token == NULL || strcmp(token, model_guid) != 0)) {
        problem = "the instantiation token is not that of this FMU";
    } else if (self->instance == NULL) {
        problem = "there is not enough memory";
    } else if (problem == NULL) {
        problem = self->instance->setup.problem;
    }
    if (problem != NULL) {
        said(self, fmi3Error, "the FMU cannot be instantiated: ", problem);
        fmi3FreeInstance(self);
        return NULL;
    }
    self->instance->exchange = exchange;
    return self;
}

fmi3Instance fmi3InstantiateCoSimulation(
    fmi3String name, fmi3String token, fmi3String resources, fmi3Boolean visible,
    fmi3Boolean logging, fmi3Boolean event_mode, fmi3Boolean early_return,
    const fmi3ValueReference intermediate[], size_t intermediates,
    fmi3InstanceEnvironment environment, fmi3LogMessageCallback log,
    fmi3IntermediateUpdateCallback update)
{
    const char *problem =
        event_mode && model_bus == NULL ? "this FMU has no event mode in co-simulation" : NULL;
    (void)name, (void)resources, (void)visible, (void)logging;
    (void)early_return, (void)intermediate, (void)intermediates, (void)update;
    struct component *self = instantiated(token, environment, log, false, problem);
    if (self != NULL) {
        self->instance->events = event_mode;
    }
    return self;
}

fmi3Instance fmi3InstantiateModelExchange(
    fmi3String name, fmi3String token, fmi3String resources, fmi3Boolean visible,
    fmi3Boolean logging, fmi3InstanceEnvironment environment, fmi3LogMessageCallback log)
{
    const char *problem = model_continuous == NULL ? "this FMU is for co-simulation" : NULL;
    (void)name, (void)resources, (void)visible, (void)logging;
    return instantiated(token, environment, log, true, problem);
}

void fmi3FreeInstance(fmi3Instance c)
{
    struct component *self = c;
    if (self != NULL) {
        instance_free(self->instance);
        memory_give(self);
    }
}

fmi3Status fmi3EnterInitializationMode(
    fmi3Instance c, fmi3Boolean tolerance_defined, fmi3Float64 tolerance, fmi3Float64 start,
    fmi3Boolean stop_defined, fmi3Float64 stop)
{
    struct component *self = c;
    (void)tolerance_defined, (void)tolerance;
    if (incomplete(self, self)) {
        return fmi3Error;
    }
    const char *problem = instance_experiment(self->instance, start, stop_defined, stop);
    return outcome(self, problem != NULL ? problem : instance_initialise(self->instance));
}

fmi3Status fmi3DoStep(
    fmi3Instance c, fmi3Float64 time, fmi3Float64 step, fmi3Boolean no_set_state,
    fmi3Boolean *event_needed, fmi3Boolean *terminate, fmi3Boolean *early_return,
    fmi3Float64 *reached)
{
    struct component *self = c;
    (void)no_set_state;
    if (incomplete(self, event_needed) || incomplete(self, terminate)
        || incomplete(self, early_return) || incomplete(self, reached)) {
        return fmi3Error;
    }
    *event_needed = *terminate = *early_return = fmi3False;
    *reached = self->instance->memory->time_s;
    const char *problem = instance_may_step(self->instance, time, step);
    if (problem != NULL) {
        return outcome(self, problem);
    }
    problem = instance_step(self->instance, time, step);
    if (problem != NULL) {
        return said(self, fmi3Discard, "the step was not made: ", problem);
    }
    *reached = self->instance->memory->time_s;
    double next_s;
    *event_needed =
        instance_next_event(self->instance, &next_s) && instance_is_due(self->instance, next_s);
    return fmi3OK;
}

/* The time follows the variables of the FMI 2.0 form. */
static const char *get_real(struct instance *self, enum kind kind, size_t ref, double *value)
{
    if (ref == model_variable_count) {
        *value = self->memory->time_s;
        return NULL;
    }
    return instance_get_real(self, kind, ref, value);
}

#define FMI_DERIVATIVES fmi3GetContinuousStateDerivatives
#define AND_COUNT , size_t value_count
#define VALUES value_count
#define LACKS(self, refs, values, count) without(self, refs, values, count, value_count)

#include "rows.h"

ROWS(Float64, fmi3Float64, REAL, double, get_real, instance_set_number)
ROWS(Int32, fmi3Int32, INTEGER, int32_t, instance_get_whole, instance_set_number)
ROWS(Boolean, fmi3Boolean, BOOLEAN, int32_t, instance_get_whole, instance_set_number)
ROWS(String, fmi3String, STRING, const char *, instance_get_string, instance_set_string)

#include "exchange.h"
#include "terminal.h"
#include "fmi3_refused.h"

#define DERIVE(NAME, SIDE, FROM, TO)                                                          \
    fmi3Status NAME(                                                                          \
        fmi3Instance c, const fmi3ValueReference unknown[], size_t unknown_count,             \
        const fmi3ValueReference known[], size_t known_count, const fmi3Float64 seeds[],      \
        size_t seed_count, fmi3Float64 found[], size_t found_count)                           \
    {                                                                                         \
        if (incomplete(c, c) || without(c, FROM, seeds, FROM##_count, seed_count)             \
            || without(c, TO, found, TO##_count, found_count)) {                              \
            return fmi3Error;                                                                 \
        }                                                                                     \
        return derive(c, SIDE, FROM, seeds, seed_count, TO, found, found_count);              \
    }

DERIVE(fmi3GetDirectionalDerivative, KNOWN, known, unknown)
DERIVE(fmi3GetAdjointDerivative, UNKNOWN, unknown, known)

fmi3Status fmi3UpdateDiscreteStates(
    fmi3Instance c, fmi3Boolean *update_needed, fmi3Boolean *terminate,
    fmi3Boolean *nominals_changed, fmi3Boolean *values_changed, fmi3Boolean *next_defined,
    fmi3Float64 *next)
{
    struct component *self = c;
    fmi3Boolean *const answers[] = {
        update_needed, terminate, nominals_changed, values_changed, next_defined};
    for (size_t i = 0; i < sizeof answers / sizeof *answers; i++) {
        if (incomplete(self, answers[i])) {
            return fmi3Error;
        }
        *answers[i] = fmi3False;
    }
    if (incomplete(self, next)) {
        return fmi3Error;
    }
    const char *problem = instance_in_event(self->instance);
    if (problem == NULL) {
        problem = instance_update(self->instance, update_needed);
    }
    *next_defined = instance_next_event(self->instance, next);
    return outcome(self, problem);
}

fmi3Status fmi3GetNumberOfContinuousStates(fmi3Instance c, size_t *count)
{
    if (incomplete(c, count)) {
        return fmi3Error;
    }
    *count = model_continuous == NULL ? 0 : model_continuous->count;
    return fmi3OK;
}

fmi3Status fmi3GetNumberOfEventIndicators(fmi3Instance c, size_t *count)
{
    if (incomplete(c, count)) {
        return fmi3Error;
    }
    *count = 0;
    return fmi3OK;
}
