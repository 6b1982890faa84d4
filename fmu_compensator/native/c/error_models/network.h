/* The feed-forward network that several kinds of error model run. */
#ifndef NETWORK_H
#define NETWORK_H

#include "../error_model.h"
#include "../numbers.h"

struct error_model *network_make(
    struct setup *setup, const struct field *table, size_t inputs, size_t targets);
void network_predict(
    const struct error_model *model, double *state, const struct sample *sample, double *targets);

#endif
