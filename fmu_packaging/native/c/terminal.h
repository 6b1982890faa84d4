/* The functions of FMI 3.0 for a bus terminal. fmi3.c includes this. */
#ifndef TERMINAL_H
#define TERMINAL_H

/* Returns the port of a value reference, and the frame of its clock; NO_PORT if it is not one. */
static enum port port_of(size_t ref, size_t *frame)
{
    size_t place = ref - model_variable_count - 1;
    *frame = 0;
    if (model_bus == NULL || ref <= model_variable_count) {
        return NO_PORT;
    }
    if (place < model_bus->rx_clocks) {
        *frame = place;
        return RX_CLOCK;
    }
    place -= model_bus->rx_clocks;
    if (place < model_bus->tx_clocks) {
        return TX_CLOCK;
    }
    place += RX_DATA - model_bus->tx_clocks;
    return model_bus->signals || place > TX_DATA ? NO_PORT : (enum port)place;
}

#define EACH(NAME, PARAMETERS, PLACES, CALL)                                                     \
    fmi3Status NAME(fmi3Instance c, const fmi3ValueReference refs[], size_t count, PARAMETERS)   \
    {                                                                                            \
        struct component *self = c;                                                              \
        if (incomplete(self, count == 0 || (refs != NULL && (PLACES)) ? self : NULL)) {          \
            return fmi3Error;                                                                    \
        }                                                                                        \
        for (size_t i = 0; i < count; i++) {                                                     \
            size_t frame;                                                                        \
            enum port port = port_of(refs[i], &frame);                                           \
            const char *problem = NULL;                                                          \
            CALL;                                                                                \
            if (problem != NULL) {                                                               \
                return variable_outcome(self, refs[i], problem);                                 \
            }                                                                                    \
        }                                                                                        \
        return fmi3OK;                                                                           \
    }
#define AND ,

EACH(fmi3GetBinary, size_t sizes[] AND fmi3Binary values[] AND size_t value_count,
     sizes != NULL && values != NULL && value_count == count,
     problem = instance_get_port(self->instance, port, &values[i], &sizes[i]))
EACH(fmi3SetBinary,
     const size_t sizes[] AND const fmi3Binary values[] AND size_t value_count,
     sizes != NULL && values != NULL && value_count == count,
     problem = instance_set_port(self->instance, port, values[i], sizes[i]))
EACH(fmi3GetClock, fmi3Clock values[], values != NULL,
     problem = instance_get_clock(self->instance, port, frame, &values[i]))
EACH(fmi3SetClock, const fmi3Clock values[], values != NULL,
     problem = instance_set_clock(self->instance, port, frame, values[i]))
EACH(fmi3GetIntervalDecimal, fmi3Float64 intervals[] AND fmi3IntervalQualifier qualifiers[],
     intervals != NULL && qualifiers != NULL,
     bool changed = false;
     problem = instance_interval(self->instance, port, &intervals[i], &changed);
     qualifiers[i] = changed ? fmi3IntervalChanged : fmi3IntervalUnchanged)

PASS(fmi3EnterStepMode, , self, instance_enter_step(self->instance))

#endif
