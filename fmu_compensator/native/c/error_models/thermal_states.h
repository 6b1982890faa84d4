/* The weighted sum of temperatures and their lags that several kinds of error model run. */
#ifndef THERMAL_STATES_H
#define THERMAL_STATES_H

#include "../error_model.h"

struct error_model *thermal_states_make(
    struct setup *setup, const struct field *table, size_t inputs, size_t targets);
void thermal_states_predict(
    const struct error_model *model, double *state, const struct sample *sample, double *targets);

#endif
