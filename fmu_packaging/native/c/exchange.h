/* The functions of model exchange shared by both versions of FMI, as in calls.h. The front that
   includes this defines FMI_DERIVATIVES, its name for the derivatives. */
#ifndef EXCHANGE_H
#define EXCHANGE_H

#define TIME , double time_s
#define ROW , double row[], size_t count
#define CONST_ROW , const double row[], size_t count
#define ROW_PLACE (count > 0 ? (const void *)row : self)

PASS(FMI(EnterEventMode), , self, instance_enter(self->instance, STEPPING))
PASS(FMI(EnterContinuousTimeMode), , self, instance_enter(self->instance, CONTINUOUS))
PASS(FMI(SetTime), TIME, self, instance_set_time(self->instance, time_s))
PASS(
    FMI(GetContinuousStates), ROW, ROW_PLACE, instance_get_states(self->instance, row, count))
PASS(
    FMI(SetContinuousStates), CONST_ROW, ROW_PLACE,
    instance_set_states(self->instance, row, count))
PASS(FMI_DERIVATIVES, ROW, ROW_PLACE, instance_get_rates(self->instance, row, count))
PASS(
    FMI(GetNominalsOfContinuousStates), ROW, ROW_PLACE,
    instance_get_nominals(self->instance, row, count))
PASS(
    FMI(GetEventIndicators), ROW, ROW_PLACE, count > 0 ? "there are no event indicators" : NULL)

FMI(Status) FMI(CompletedIntegratorStep)(
    FMI_INSTANCE c, FMI(Boolean) no_set_state, FMI(Boolean) *event_mode, FMI(Boolean) *terminate)
{
    struct component *self = c;
    (void)no_set_state;
    if (incomplete(self, event_mode) || incomplete(self, terminate)) {
        return FMI(Error);
    }
    *event_mode = *terminate = 0;
    return outcome(self, instance_complete(self->instance));
}

/* Computes derivatives from seeds of one side's variables to those of the other side. */
static FMI(Status) derive(
    struct component *self, enum side from, const FMI(ValueReference) refs[], const double seeds[],
    size_t count, const FMI(ValueReference) others[], double found[], size_t other_count)
{
    enum side to = from == KNOWN ? UNKNOWN : KNOWN;
    if (incomplete(self, count == 0 || (refs != NULL && seeds != NULL) ? self : NULL)
        || incomplete(self, other_count == 0 || (others != NULL && found != NULL) ? self : NULL)) {
        return FMI(Error);
    }
    struct cursor cursor = {0, 0}, other = {0, 0};
    const char *problem = instance_begin_derivatives(self->instance);
    for (size_t i = 0; problem == NULL && i < count; i++) {
        problem = instance_seed(self->instance, from, next_ref(&cursor, refs), seeds[i]);
    }
    problem = problem == NULL ? instance_derive(self->instance, from) : problem;
    for (size_t i = 0; problem == NULL && i < other_count; i++) {
        problem =
            instance_get_derivative(self->instance, to, next_ref(&other, others), &found[i]);
    }
    return outcome(self, problem);
}

#endif
