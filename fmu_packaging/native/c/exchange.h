/* The functions of model exchange that both versions of FMI have. The front that includes this says
   FMI(name), FMI_INSTANCE, and FMI_DERIVATIVES, what it calls the derivatives. */
#ifndef EXCHANGE_H
#define EXCHANGE_H

#define EXCHANGE(NAME, PARAMETER, PLACE, CALL)                                        \
    FMI(Status) NAME(FMI_INSTANCE c PARAMETER)                                        \
    {                                                                                 \
        struct component *self = c;                                                   \
        return incomplete(self, PLACE) ? FMI(Error) : outcome(self, CALL);            \
    }
#define TIME , double time_s
#define ROW , double row[], size_t count
#define CONST_ROW , const double row[], size_t count
#define ROW_PLACE (count > 0 ? (const void *)row : self)

EXCHANGE(FMI(EnterEventMode), , self, instance_enter(self->instance, STEPPING))
EXCHANGE(FMI(EnterContinuousTimeMode), , self, instance_enter(self->instance, CONTINUOUS))
EXCHANGE(FMI(SetTime), TIME, self, instance_set_time(self->instance, time_s))
EXCHANGE(
    FMI(GetContinuousStates), ROW, ROW_PLACE, instance_get_states(self->instance, row, count))
EXCHANGE(
    FMI(SetContinuousStates), CONST_ROW, ROW_PLACE,
    instance_set_states(self->instance, row, count))
EXCHANGE(FMI_DERIVATIVES, ROW, ROW_PLACE, instance_get_rates(self->instance, row, count))
EXCHANGE(
    FMI(GetNominalsOfContinuousStates), ROW, ROW_PLACE,
    instance_get_nominals(self->instance, row, count))
EXCHANGE(
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

#endif
