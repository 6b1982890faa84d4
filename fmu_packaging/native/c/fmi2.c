/* FMI 2.0 in front of an instance. */
#include "fmi2Functions.h"

#include <stdio.h>
#include <string.h>

#include "instance.h"
#include "memory.h"
#include "model.h"

#define NAME_ROOM 72 /* shorter names take the same memory: see memory.c */

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

#define FMI(name) fmi2##name
#define FMI_INSTANCE fmi2Component
#define FMI_STATE(before, after) fmi2##before##FMUstate##after
#define FMI_STATE_OF_BYTES fmi2DeSerializeFMUstate

#include "calls.h"

/* The same for a call with rows of values, which may be empty. */
static bool without(const struct component *self, const void *refs, const void *values, size_t count)
{
    return incomplete(self, count == 0 || (refs != NULL && values != NULL) ? self : NULL);
}

const char *fmi2GetTypesPlatform(void)
{
    return fmi2TypesPlatform;
}

const char *fmi2GetVersion(void)
{
    return fmi2Version;
}

/* Returns why an instance cannot be used, or NULL. */
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
    /* Every message is the reason of a refusal: there is no debug logging to ask for. */
    (void)resources, (void)visible, (void)logging;
    if (self == NULL) {
        return NULL;
    }
    self->host = host;
    self->logged = ~0u;
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
    return incomplete(self, self)
               ? fmi2Error
               : outcome(self, instance_experiment(self->instance, start, stop_defined, stop));
}

PASS(fmi2EnterInitializationMode, , self, instance_initialise(self->instance))

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

#define FMI_DERIVATIVES fmi2GetDerivatives
#define AND_COUNT
#define VALUES count
#define ELEMENTS(ref) 1
#define LACKS(self, refs, values, count) without(self, refs, values, count)

#include "rows.h"

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

fmi2Status fmi2GetDirectionalDerivative(
    fmi2Component c, const fmi2ValueReference unknown[], size_t unknowns,
    const fmi2ValueReference known[], size_t knowns, const fmi2Real seed[], fmi2Real change[])
{
    return derive(c, KNOWN, known, seed, knowns, unknown, change, unknowns);
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
