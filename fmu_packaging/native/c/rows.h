/* The rows of values passed in both versions of FMI, as in calls.h. The front that includes this
   defines AND_COUNT (arguments after the values), VALUES (their number), LACKS (whether something
   is missing) and ELEMENTS (number of values of a reference). */
#ifndef ROWS_H
#define ROWS_H

struct cursor {
    size_t at, element; /* place among the references, and in an array */
};

/* Returns the reference of the next value; those of an array are consecutive. */
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
        /* First check all, then set all. */                                                    \
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
