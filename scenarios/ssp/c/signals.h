/* A table of held values: the generated signals_size.h says how large, model_data.c holds it. */
#ifndef SIGNALS_H
#define SIGNALS_H

#include "model.h"
#include "signals_size.h"

struct outputs {
    double shown[SIGNALS];
};

extern const double signals_times[ROWS]; /* [s], rising */
extern const double signals_values[ROWS][SIGNALS];

#endif
