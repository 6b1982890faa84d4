/* The rows of values that both versions of FMI pass. They go by calls.h; the front that includes
   this says AND_COUNT, what stands behind the values, and LACKS, whether something is missing. */
#ifndef ROWS_H
#define ROWS_H

#define ROWS(NAME, TYPE, KIND, HELD, GET, SET)                                                  \
    FMI(Status) FMI(Get##NAME)(                                                                 \
        FMI_INSTANCE c, const FMI(ValueReference) refs[], size_t count, TYPE values[] AND_COUNT) \
    {                                                                                           \
        struct component *self = c;                                                             \
        if (LACKS(self, refs, values, count)) {                                                 \
            return FMI(Error);                                                                  \
        }                                                                                       \
        for (size_t i = 0; i < count; i++) {                                                    \
            HELD value;                                                                         \
            const char *problem = GET(self->instance, KIND, refs[i], &value);                   \
            if (problem != NULL) {                                                              \
                return variable_outcome(self, refs[i], problem);                                \
            }                                                                                   \
            values[i] = (TYPE)value;                                                            \
        }                                                                                       \
        return FMI(OK);                                                                         \
    }                                                                                           \
    FMI(Status) FMI(Set##NAME)(                                                                 \
        FMI_INSTANCE c, const FMI(ValueReference) refs[], size_t count,                         \
        const TYPE values[] AND_COUNT)                                                          \
    {                                                                                           \
        struct component *self = c;                                                             \
        if (LACKS(self, refs, values, count)) {                                                 \
            return FMI(Error);                                                                  \
        }                                                                                       \
        /* First whether all can be set, then all. */                                           \
        for (size_t i = 0; i < 2 * count; i++) {                                                \
            size_t at = i % count;                                                              \
            const char *problem = SET(self->instance, KIND, refs[at], values[at], i >= count);  \
            if (problem != NULL) {                                                              \
                return variable_outcome(self, refs[at], problem);                               \
            }                                                                                   \
        }                                                                                       \
        return FMI(OK);                                                                         \
    }

#endif
