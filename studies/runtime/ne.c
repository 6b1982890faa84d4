/* Natural exponential: z(t) = z0 + (zss(n) - z0) (1 - exp(-t / tau)), anew at each change of speed.

   State: the speed at the previous sample [rpm], the drift. */
#include "../constants.h"
#include "../error_model.h"
#include "../numbers.h"

struct ne {
    struct error_model base;
    size_t targets, speeds;
    const double *speeds_rpm, *steady, *tau_s, *tau_stopped_s;
};

static struct error_model *make(
    struct setup *setup, const struct field *table, size_t inputs, size_t targets)
{
    struct ne *self = setup_take(setup, 1, sizeof *self);
    (void)inputs;
    if (self == NULL) {
        return NULL;
    }
    self->base.states = 1 + targets;
    self->targets = targets;
    self->speeds_rpm = field_numbers(setup, table, "speeds_rpm", &self->speeds);
    self->steady = field_matrix(setup, table, "steady", NULL);
    self->tau_s = field_numbers(setup, table, "tau_s", NULL);
    self->tau_stopped_s = field_numbers(setup, table, "tau_stopped_s", NULL);
    return &self->base;
}

/* The knots are standstill with zero drift, and then the speeds of the file. */
static double knot(const double *row, size_t place)
{
    return place == 0 ? 0.0 : row[place - 1];
}

/* Returns the knot below a speed and the fraction to the next; clipped at the last knot. */
static size_t place_of(const struct ne *self, double speed, double *part)
{
    size_t place = 0;
    if (speed >= knot(self->speeds_rpm, self->speeds)) {
        *part = 1.0;
        return self->speeds - 1;
    }
    while (speed >= knot(self->speeds_rpm, place + 1)) {
        place++;
    }
    double low = knot(self->speeds_rpm, place), high = knot(self->speeds_rpm, place + 1);
    *part = (speed - low) / (high - low);
    return place;
}

static void predict(
    const struct error_model *model, double *state, const struct sample *sample, double *targets)
{
    const struct ne *self = (const struct ne *)model;
    double *speed = state, *drift = state + 1, part = 0.0;
    size_t place = place_of(self, *speed, &part);
    for (size_t target = 0; target < self->targets; target++) {
        const double *steady = self->steady + target * self->speeds;
        double below = knot(steady, place);
        double goal = below + part * (knot(steady, place + 1) - below);
        double tau = *speed >= LAGS_STILL_RPM ? self->tau_s[target] : self->tau_stopped_s[target];
        drift[target] += lag_share(sample->elapsed_s, tau) * (goal - drift[target]);
        targets[target] = drift[target];
    }
    *speed = known_speed(sample->speed, *speed);
}

const struct error_model_kind ne_kind = {"ne", make, NULL, predict};
