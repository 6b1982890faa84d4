/* Predicts the drift of the measured quantities from checked temperatures.

   A model is constant after construction. Its state is an array of numbers kept by its owner, in
   the order of the Python twin's state(); so the two can be compared number by number, and an FMU
   state is a copy of memory. */
#ifndef ERROR_MODEL_H
#define ERROR_MODEL_H

#include <stddef.h>

#include "fields.h"
#include "setup.h"

struct sample {
    const double *inputs;   /* the chosen temperatures in the file's input form [degC or K] */
    double elapsed_s;       /* since the previous sample; 0 for the first */
    double speed;           /* of the spindle [rpm]; NaN: unknown */
    const double *measured; /* targets at the previous sample; NULL: not measured [um, urad] */
};

struct error_model {
    const struct error_model_kind *kind;
    size_t states; /* length of its state */
};

struct error_model_kind {
    const char *name;
    /* Makes a model from the file's table; NULL or a noted problem on failure. */
    struct error_model *(*make)(
        struct setup *setup, const struct field *table, size_t inputs, size_t targets);
    /* Resets a zeroed state; NULL if zeros are the initial state. */
    void (*reset)(const struct error_model *model, double *state);
    /* Computes the predicted targets [um, urad]. */
    void (*predict)(
        const struct error_model *model, double *state, const struct sample *sample,
        double *targets);
};

/* Makes the model of a table of the file, selected by its field "kind". */
struct error_model *error_model_make(
    struct setup *setup, const struct field *table, size_t inputs, size_t targets);

void error_model_reset(const struct error_model *model, double *state);

#endif
