/* Multiple linear regression: y = b0 + sum(b_i x_i). */
#include "../model_data.h"

struct mlr {
    struct error_model base;
    const double *intercept, *coefficients;
};

static struct error_model *make(
    struct setup *setup, const struct field *table, size_t inputs, size_t targets)
{
    struct mlr *self = setup_take(setup, 1, sizeof *self);
    if (self == NULL) {
        return NULL;
    }
    (void)inputs, (void)targets;
    self->intercept = field_numbers(setup, table, "intercept", NULL);
    self->coefficients = field_matrix(setup, table, "coefficients", NULL);
    return &self->base;
}

static void predict(
    const struct error_model *model, double *state, const struct sample *sample, double *targets)
{
    const struct mlr *self = (const struct mlr *)model;
    (void)state;
    for (size_t target = 0; target < model_target_count; target++) {
        const double *weights = self->coefficients + target * model_chosen_count;
        double value = self->intercept[target];
        for (size_t i = 0; i < model_chosen_count; i++) {
            value += weights[i] * sample->inputs[i];
        }
        targets[target] = value;
    }
}

const struct error_model_kind mlr_kind = {"mlr", make, NULL, predict};
