/* The rows of values that both versions of FMI pass. They go by calls.h; the front that includes
   this says AND_COUNT, what stands behind the values, VALUES, how many they are, LACKS, whether
   something is missing, and ELEMENTS, how many values stand under a reference. */
#ifndef ROWS_H
#define ROWS_H

struct cursor {
    size_t at, element; /* among the references, and of an array */
};

/* Returns the reference of the next value; those of an array follow one another. */
static FMI(ValueReference) next_ref(struct cursor *cursor, const FMI(ValueReference) refs[])
{
    FMI(ValueReference) first = refs[cursor->at], ref = first + (FMI(ValueReference))cursor->element;
    cursor->element++;
    if (cursor->element >= ELEMENTS(first)) {
        *cursor = (struct cursor){cursor->at + 1, 0};
    }
    return ref;
}

#define ROWS(NAME, TYPE, KIND, HELD, GET, SET)                                                  \
    FMI(Status) FMI(Get##NAME)(                                                                 \
        FMI_INSTANCE c, const FMI(ValueReference) refs[], size_t count, TYPE values[] AND_COUNT)\
    {                                                                                           \
        struct component *self = c;                                                             \
        if (LACKS(self, refs, values, count)) {                                                 \
            return FMI(Error);                                                                  \
        }                                                                                       \
        struct cursor cursor = {0, 0};                                                          \
        for (size_t i = 0; i < VALUES; i++) {                                                   \
            HELD value;                                                                         \
            FMI(ValueReference) ref = next_ref(&cursor, refs);                                  \
            const char *problem = GET(self->instance, KIND, ref, &value);                       \
            if (problem != NULL) {                                                              \
                return variable_outcome(self, ref, problem);                                    \
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
        for (int really = 0; really < 2; really++) {                                            \
            struct cursor cursor = {0, 0};                                                      \
            for (size_t i = 0; i < VALUES; i++) {                                               \
                FMI(ValueReference) ref = next_ref(&cursor, refs);                              \
                const char *problem = SET(self->instance, KIND, ref, values[i], really != 0);   \
                if (problem != NULL) {                                                          \
                    return variable_outcome(self, ref, problem);                                \
                }                                                                               \
            }                                                                                   \
        }                                                                                       \
        return FMI(OK);                                                                         \
    }

#endif
