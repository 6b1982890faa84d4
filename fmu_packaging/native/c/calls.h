/* The calls shared by both versions of FMI except for names and types. The front that includes this
   defines a struct component, said() for messages, FMI(name), FMI_INSTANCE, FMI_STATE(before,
   after), the functions of a state, and FMI_STATE_OF_BYTES. */
#ifndef CALLS_H
#define CALLS_H

static FMI(Status) outcome(const struct component *self, const char *problem)
{
    return problem == NULL ? FMI(OK) : said(self, FMI(Error), "", problem);
}

/* Whether a call lacks its instance, or the pointer for its result or values. */
static bool incomplete(const struct component *self, const void *place)
{
    return outcome(self, self == NULL || place == NULL ? "a null pointer" : NULL) != FMI(OK);
}

static FMI(Status) variable_outcome(
    const struct component *self, FMI(ValueReference) ref, const char *problem)
{
    char about[80];
    if (ref < model_variable_count) {
        snprintf(about, sizeof about, "%.70s: ", model_variables[ref].name);
    } else {
        snprintf(about, sizeof about, "value reference %u: ", (unsigned)ref);
    }
    return said(self, FMI(Error), about, problem);
}

/* A call with the result of CALL and self as its component; PLACE must not be NULL. */
#define PASS(NAME, PARAMETERS, PLACE, CALL)                                           \
    FMI(Status) NAME(FMI_INSTANCE c PARAMETERS)                                       \
    {                                                                                 \
        struct component *self = c;                                                   \
        return incomplete(self, PLACE) ? FMI(Error) : outcome(self, CALL);            \
    }
#define LOGGING , FMI(Boolean) on, size_t count, const FMI(String) categories[]

PASS(FMI(SetDebugLogging), LOGGING, self,
     instance_log(&self->logged, on, count, categories) ? NULL : "there is no such log category")
PASS(FMI(ExitInitializationMode), , self, instance_start(self->instance))
PASS(FMI(Terminate), , self, instance_terminate(self->instance))
PASS(FMI(Reset), , self, (instance_reset(self->instance), NULL))

FMI(Status) FMI_STATE(Get, )(FMI_INSTANCE c, FMI_STATE(, ) *state)
{
    struct component *self = c;
    if (incomplete(self, state)) {
        return FMI(Error);
    }
    /* A host may pass an earlier state to be reused. */
    if (*state == NULL) {
        *state = instance_state(self->instance);
    } else {
        memcpy(*state, self->instance->memory, self->instance->memory_size);
    }
    return outcome(self, *state == NULL ? "there is not enough memory for the state" : NULL);
}

FMI(Status) FMI_STATE(Set, )(FMI_INSTANCE c, FMI_STATE(, ) state)
{
    struct component *self = c;
    if (incomplete(self, self)) {
        return FMI(Error);
    }
    if (state == NULL) {
        return outcome(self, "there is no state to continue from");
    }
    instance_restore(self->instance, state);
    return FMI(OK);
}

FMI(Status) FMI_STATE(Free, )(FMI_INSTANCE c, FMI_STATE(, ) *state)
{
    (void)c;
    if (state != NULL) {
        memory_give(*state);
        *state = NULL;
    }
    return FMI(OK);
}

FMI(Status) FMI_STATE(Serialized, Size)(FMI_INSTANCE c, FMI_STATE(, ) state, size_t *size)
{
    struct component *self = c;
    if (incomplete(self, size)) {
        return FMI(Error);
    }
    (void)state;
    *size = state_bytes_size(self->instance);
    return FMI(OK);
}

FMI(Status) FMI_STATE(Serialize, )(
    FMI_INSTANCE c, FMI_STATE(, ) state, FMI(Byte) bytes[], size_t size)
{
    struct component *self = c;
    if (incomplete(self, bytes)) {
        return FMI(Error);
    }
    if (state == NULL || size < state_bytes_size(self->instance)) {
        return outcome(self, "the state does not fit into the bytes given for it");
    }
    state_to_bytes(self->instance, state, bytes);
    return FMI(OK);
}

FMI(Status) FMI_STATE_OF_BYTES(
    FMI_INSTANCE c, const FMI(Byte) bytes[], size_t size, FMI_STATE(, ) *state)
{
    struct component *self = c;
    const char *problem = NULL;
    if (incomplete(self, bytes) || incomplete(self, state)) {
        return FMI(Error);
    }
    *state = state_from_bytes(self->instance, bytes, size, &problem);
    return outcome(self, problem);
}

#endif
