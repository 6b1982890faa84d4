/* A table of held values: its size is in the generated signals_size.h, its data in model_data.c. */
#ifndef SIGNALS_H
#define SIGNALS_H

#include "model.h"
#include "signals_size.h"

struct outputs {
    double shown[SIGNALS];
};

extern const double signals_times[ROWS]; /* [s], increasing */
extern const double signals_values[ROWS][SIGNALS];

#endif
