/* From checked temperatures to the drift of the measured quantities.

   A model is constant once it is made. What it remembers is a row of numbers that its owner keeps,
   in the order in which the Python twin's state() lists them; so the two can be compared number by
   number, and an FMU state is a copy of memory. */
#ifndef ERROR_MODEL_H
#define ERROR_MODEL_H

#include <stddef.h>

#include "fields.h"
#include "setup.h"

struct sample {
    const double *inputs;   /* the chosen temperatures in the file's input form [degC or K] */
    double elapsed_s;       /* since the sample before this one; 0 for the first */
    double speed;           /* of the spindle [rpm]; NaN: not known */
    const double *measured; /* the targets at the sample before; NULL: not measured [um, urad] */
};

struct error_model {
    const struct error_model_kind *kind;
    size_t states; /* how many numbers it remembers */
};

struct error_model_kind {
    const char *name;
    /* Makes a model from the file's table; NULL or a noted problem when that fails. */
    struct error_model *(*make)(
        struct setup *setup, const struct field *table, size_t inputs, size_t targets);
    /* Forgets everything, in a state that is zeroed; NULL where zeros are a fresh state. */
    void (*reset)(const struct error_model *model, double *state);
    /* Puts down the predicted targets [um, urad]. */
    void (*predict)(
        const struct error_model *model, double *state, const struct sample *sample,
        double *targets);
};

/* Makes the model that a table of the file describes, by its field "kind". */
struct error_model *error_model_make(
    struct setup *setup, const struct field *table, size_t inputs, size_t targets);

void error_model_reset(const struct error_model *model, double *state);

#endif
