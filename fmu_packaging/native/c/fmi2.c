/* FMI 2.0 in front of an instance. */
#include "fmi2Functions.h"

#include <stdio.h>
#include <string.h>

#include "instance.h"
#include "memory.h"
#include "model.h"
#include "rows.h"

#define NAME_ROOM 72 /* names up to it take the same: see memory.c */

struct component {
    struct instance *instance;
    const fmi2CallbackFunctions *host;
    char *name;
    unsigned logged; /* categories */
};

static fmi2Status said(
    const struct component *self, fmi2Status status, const char *about, const char *text)
{
    char message[2 * PROBLEM_LENGTH];
    enum category category = status == fmi2Discard ? DISCARDED : REFUSED;
    if (self != NULL && (self->logged >> category & 1u) && self->host != NULL
        && self->host->logger != NULL) {
        snprintf(message, sizeof message, "%s%s", about, text);
        self->host->logger(
            self->host->componentEnvironment, self->name, status, category_names[category], "%s",
            message);
    }
    return status;
}

static fmi2Status outcome(const struct component *self, const char *problem)
{
    return problem == NULL ? fmi2OK : said(self, fmi2Error, "", problem);
}

/* Whether a call lacks its instance, or the place that its result or its values come to. */
static bool incomplete(const struct component *self, const void *place)
{
    return outcome(self, self == NULL || place == NULL ? "a null pointer" : NULL) != fmi2OK;
}

/* The same for a call with rows of values, which may be empty. */
static bool without(const struct component *self, const void *refs, const void *values, size_t count)
{
    return incomplete(self, count == 0 || (refs != NULL && values != NULL) ? self : NULL);
}

static fmi2Status variable_outcome(
    const struct component *self, fmi2ValueReference ref, const char *problem)
{
    char about[80];
    snprintf(about, sizeof about, "value reference %u: ", ref);
    return said(self, fmi2Error, about, problem);
}

const char *fmi2GetTypesPlatform(void)
{
    return fmi2TypesPlatform;
}

const char *fmi2GetVersion(void)
{
    return fmi2Version;
}

fmi2Status fmi2SetDebugLogging(
    fmi2Component c, fmi2Boolean on, size_t count, const fmi2String categories[])
{
    struct component *self = c;
    if (incomplete(self, self)) {
        return fmi2Error;
    }
    const char *problem = "there is no such log category";
    return outcome(self, instance_log(&self->logged, on, count, categories) ? NULL : problem);
}

/* Returns what keeps an instance from being used, NULL for nothing. */
static const char *unusable(const struct component *self, fmi2Type type, const char *guid)
{
    if (type != fmi2CoSimulation && (type != fmi2ModelExchange || model_continuous == NULL)) {
        return "this FMU is for co-simulation";
    }
    if (guid == NULL || strcmp(guid, model_guid) != 0) {
        return "the GUID is not that of this FMU";
    }
    return self->instance == NULL ? "there is not enough memory" : self->instance->setup.problem;
}

fmi2Component fmi2Instantiate(
    fmi2String name, fmi2Type type, fmi2String guid, fmi2String resources,
    const fmi2CallbackFunctions *host, fmi2Boolean visible, fmi2Boolean logging)
{
    struct component *self = memory_take(1, sizeof *self);
    const char *given = name == NULL ? "" : name;
    (void)resources, (void)visible;
    if (self == NULL) {
        return NULL;
    }
    self->host = host;
    self->logged = logging ? ~0u : 0u;
    self->instance = instance_new();
    size_t length = strlen(given) + 1;
    self->name = memory_take(1, length < NAME_ROOM ? NAME_ROOM : length);
    if (self->name != NULL) {
        strcpy(self->name, given);
    }
    const char *problem = unusable(self, type, guid);
    if (problem != NULL || self->name == NULL) {
        said(self, fmi2Error, "the FMU cannot be instantiated: ", problem == NULL ? "" : problem);
        fmi2FreeInstance(self);
        return NULL;
    }
    self->instance->exchange = type == fmi2ModelExchange;
    return self;
}

void fmi2FreeInstance(fmi2Component c)
{
    struct component *self = c;
    if (self != NULL) {
        instance_free(self->instance);
        memory_give(self->name);
        memory_give(self);
    }
}

fmi2Status fmi2SetupExperiment(
    fmi2Component c, fmi2Boolean tolerance_defined, fmi2Real tolerance, fmi2Real start,
    fmi2Boolean stop_defined, fmi2Real stop)
{
    struct component *self = c;
    (void)tolerance_defined, (void)tolerance;
    if (incomplete(self, self)) {
        return fmi2Error;
    }
    return outcome(self, instance_experiment(self->instance, start, stop_defined, stop));
}

fmi2Status fmi2EnterInitializationMode(fmi2Component c)
{
    struct component *self = c;
    return incomplete(self, self) ? fmi2Error : outcome(self, instance_initialise(self->instance));
}

fmi2Status fmi2ExitInitializationMode(fmi2Component c)
{
    struct component *self = c;
    return incomplete(self, self) ? fmi2Error : outcome(self, instance_start(self->instance));
}

fmi2Status fmi2Terminate(fmi2Component c)
{
    struct component *self = c;
    return incomplete(self, self) ? fmi2Error : outcome(self, instance_terminate(self->instance));
}

fmi2Status fmi2Reset(fmi2Component c)
{
    struct component *self = c;
    if (incomplete(self, self)) {
        return fmi2Error;
    }
    instance_reset(self->instance);
    return fmi2OK;
}

fmi2Status fmi2DoStep(fmi2Component c, fmi2Real time, fmi2Real step, fmi2Boolean no_set_state)
{
    struct component *self = c;
    (void)no_set_state;
    if (incomplete(self, self)) {
        return fmi2Error;
    }
    const char *problem = instance_may_step(self->instance, time, step);
    if (problem != NULL) {
        return outcome(self, problem);
    }
    problem = instance_step(self->instance, time, step);
    return problem == NULL ? fmi2OK
                           : said(self, fmi2Discard, "the step was not made: ", problem);
}

#define FMI(name) fmi2##name
#define FMI_INSTANCE fmi2Component
#define FMI_DERIVATIVES fmi2GetDerivatives
#define AND_COUNT
#define LACKS(self, refs, values, count) without(self, refs, values, count)

ROWS(Real, fmi2Real, REAL, double, instance_get_real, instance_set_number)
ROWS(Integer, fmi2Integer, INTEGER, int32_t, instance_get_whole, instance_set_number)
ROWS(Boolean, fmi2Boolean, BOOLEAN, int32_t, instance_get_whole, instance_set_number)
ROWS(String, fmi2String, STRING, const char *, instance_get_string, instance_set_string)

#include "exchange.h"

fmi2Status fmi2NewDiscreteStates(fmi2Component c, fmi2EventInfo *info)
{
    struct component *self = c;
    if (incomplete(self, info)) {
        return fmi2Error;
    }
    memset(info, 0, sizeof *info);
    return outcome(self, instance_in_event(self->instance));
}

fmi2Status fmi2GetFMUstate(fmi2Component c, fmi2FMUstate *state)
{
    struct component *self = c;
    if (incomplete(self, state)) {
        return fmi2Error;
    }
    /* A host may hand in a state of before, to be used again. */
    if (*state == NULL) {
        *state = instance_state(self->instance);
    } else {
        memcpy(*state, self->instance->memory, self->instance->memory_size);
    }
    return outcome(self, *state == NULL ? "there is not enough memory for the state" : NULL);
}

fmi2Status fmi2SetFMUstate(fmi2Component c, fmi2FMUstate state)
{
    struct component *self = c;
    if (incomplete(self, self)) {
        return fmi2Error;
    }
    if (state == NULL) {
        return outcome(self, "there is no state to continue from");
    }
    instance_restore(self->instance, state);
    return fmi2OK;
}

fmi2Status fmi2FreeFMUstate(fmi2Component c, fmi2FMUstate *state)
{
    (void)c;
    if (state != NULL) {
        memory_give(*state);
        *state = NULL;
    }
    return fmi2OK;
}

fmi2Status fmi2SerializedFMUstateSize(fmi2Component c, fmi2FMUstate state, size_t *size)
{
    struct component *self = c;
    if (incomplete(self, size)) {
        return fmi2Error;
    }
    (void)state;
    *size = state_bytes_size(self->instance);
    return fmi2OK;
}

fmi2Status fmi2SerializeFMUstate(
    fmi2Component c, fmi2FMUstate state, fmi2Byte bytes[], size_t size)
{
    struct component *self = c;
    if (incomplete(self, bytes)) {
        return fmi2Error;
    }
    if (state == NULL || size < state_bytes_size(self->instance)) {
        return outcome(self, "the state does not fit into the bytes given for it");
    }
    state_to_bytes(self->instance, state, bytes);
    return fmi2OK;
}

fmi2Status fmi2DeSerializeFMUstate(
    fmi2Component c, const fmi2Byte bytes[], size_t size, fmi2FMUstate *state)
{
    struct component *self = c;
    const char *problem = NULL;
    if (incomplete(self, bytes) || incomplete(self, state)) {
        return fmi2Error;
    }
    *state = state_from_bytes(self->instance, bytes, size, &problem);
    return outcome(self, problem);
}

fmi2Status fmi2GetDirectionalDerivative(
    fmi2Component c, const fmi2ValueReference unknown[], size_t unknowns,
    const fmi2ValueReference known[], size_t knowns, const fmi2Real seed[], fmi2Real change[])
{
    return derive(c, KNOWN, known, knowns, seed, unknown, unknowns, change);
}

fmi2Status fmi2SetRealInputDerivatives(
    fmi2Component c, const fmi2ValueReference refs[], size_t count, const fmi2Integer order[],
    const fmi2Real values[])
{
    (void)refs, (void)count, (void)order, (void)values;
    return outcome(c, "this FMU does not interpolate its inputs");
}

fmi2Status fmi2GetRealOutputDerivatives(
    fmi2Component c, const fmi2ValueReference refs[], size_t count, const fmi2Integer order[],
    fmi2Real values[])
{
    (void)refs, (void)count, (void)order, (void)values;
    return outcome(c, "this FMU gives no derivatives");
}

fmi2Status fmi2CancelStep(fmi2Component c)
{
    return outcome(c, "this FMU makes no step that could be cancelled");
}

fmi2Status fmi2GetStatus(fmi2Component c, const fmi2StatusKind kind, fmi2Status *value)
{
    (void)c, (void)kind;
    if (value != NULL) {
        *value = fmi2OK;
    }
    return fmi2Discard;
}

fmi2Status fmi2GetRealStatus(fmi2Component c, const fmi2StatusKind kind, fmi2Real *value)
{
    struct component *self = c;
    if (self == NULL || value == NULL || kind != fmi2LastSuccessfulTime) {
        return fmi2Discard;
    }
    *value = self->instance->memory->time_s;
    return fmi2OK;
}

fmi2Status fmi2GetIntegerStatus(fmi2Component c, const fmi2StatusKind kind, fmi2Integer *value)
{
    (void)c, (void)kind, (void)value;
    return fmi2Discard;
}

fmi2Status fmi2GetBooleanStatus(fmi2Component c, const fmi2StatusKind kind, fmi2Boolean *value)
{
    (void)c, (void)kind;
    if (value != NULL) {
        *value = fmi2False;
    }
    return fmi2Discard;
}

fmi2Status fmi2GetStringStatus(fmi2Component c, const fmi2StatusKind kind, fmi2String *value)
{
    (void)c, (void)kind;
    if (value != NULL) {
        *value = "";
    }
    return fmi2Discard;
}
