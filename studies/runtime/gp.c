/* Gaussian-process regression on temperatures and their lags: a plane and bumps.

   State: the lagged inputs lag by lag. */
#include <math.h>
#include <string.h>

#include "../error_model.h"
#include "../numbers.h"

struct gp {
    struct error_model base;
    size_t inputs, targets, lags, width, centres;
    double sharpness; /* 1 / (2 l^2) [1/K^2] */
    const double *lags_s, *constant, *linear, *centre, *weights;
    double *features, *bumps; /* of one sample */
};

static struct error_model *make(
    struct setup *setup, const struct field *table, size_t inputs, size_t targets)
{
    struct gp *self = setup_take(setup, 1, sizeof *self);
    if (self == NULL) {
        return NULL;
    }
    double length = field_number(setup, table, "length");
    self->inputs = inputs;
    self->targets = targets;
    self->sharpness = 0.5 / (length * length);
    self->lags_s = field_numbers(setup, table, "lags_s", &self->lags);
    self->constant = field_numbers(setup, table, "constant", NULL);
    self->linear = field_matrix(setup, table, "linear", NULL);
    self->centre = field_matrix(setup, table, "centres", &self->centres);
    self->weights = field_matrix(setup, table, "weights", NULL);
    self->width = inputs * (1 + self->lags);
    self->features = setup_take(setup, self->width, sizeof(double));
    self->bumps = setup_take(setup, self->centres, sizeof(double));
    self->base.states = self->lags * inputs;
    return &self->base;
}

/* Advances the lags and sets the features: inputs, then lag by lag. */
static void make_features(
    const struct gp *self, double *lagged, const double *inputs, double elapsed_s)
{
    double *features = self->features;
    memcpy(features, inputs, self->inputs * sizeof(double));
    for (size_t lag = 0; lag < self->lags; lag++) {
        double part = lag_share(elapsed_s, self->lags_s[lag]);
        features += self->inputs;
        for (size_t i = 0; i < self->inputs; i++) {
            lagged[i] += part * (inputs[i] - lagged[i]);
            features[i] = lagged[i];
        }
        lagged += self->inputs;
    }
}

static double bump(const struct gp *self, const double *centre)
{
    double away = 0.0;
    for (size_t i = 0; i < self->width; i++) {
        away += (self->features[i] - centre[i]) * (self->features[i] - centre[i]);
    }
    return exp(-self->sharpness * away);
}

static void predict(
    const struct error_model *model, double *state, const struct sample *sample, double *targets)
{
    const struct gp *self = (const struct gp *)model;
    make_features(self, state, sample->inputs, sample->elapsed_s);
    for (size_t i = 0; i < self->centres; i++) {
        self->bumps[i] = bump(self, self->centre + i * self->width);
    }
    for (size_t target = 0; target < self->targets; target++) {
        const double *linear = self->linear + target * self->width;
        const double *weights = self->weights + target * self->centres;
        targets[target] = self->constant[target] + dot(linear, self->features, self->width)
                          + dot(weights, self->bumps, self->centres);
    }
}

const struct error_model_kind gp_kind = {"gp", make, NULL, predict};
