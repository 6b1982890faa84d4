/* ARX: y(k) = a y(k-1) + sum_l B_l u(k-l) + c, one pole per target, on an even clock.

   State: started, age of the step [s], the last inputs, the drift. */
#include "../constants.h"
#include "../error_model.h"
#include "../numbers.h"

struct arx {
    struct error_model base;
    size_t inputs, targets;
    double step_s;
    const double *pole, *now, *before, *constant;
};

static struct error_model *make(
    struct setup *setup, const struct field *table, size_t inputs, size_t targets)
{
    struct arx *self = setup_take(setup, 1, sizeof *self);
    if (self == NULL) {
        return NULL;
    }
    self->base.states = 2 + inputs + targets;
    self->inputs = inputs;
    self->targets = targets;
    self->step_s = field_number(setup, table, "step_s");
    self->pole = field_numbers(setup, table, "pole", NULL);
    self->now = field_matrix(setup, table, "now", NULL);
    self->before = field_matrix(setup, table, "before", NULL);
    self->constant = field_numbers(setup, table, "constant", NULL);
    return &self->base;
}

static void tick(const struct arx *self, const double *inputs, double *last, double *drift)
{
    for (size_t target = 0; target < self->targets; target++) {
        const double *now = self->now + target * self->inputs;
        const double *before = self->before + target * self->inputs;
        double value = self->pole[target] * drift[target] + self->constant[target];
        for (size_t i = 0; i < self->inputs; i++) {
            value += now[i] * inputs[i] + before[i] * last[i];
        }
        drift[target] = value;
    }
    for (size_t i = 0; i < self->inputs; i++) {
        last[i] = inputs[i];
    }
}

static void predict(
    const struct error_model *model, double *state, const struct sample *sample, double *targets)
{
    const struct arx *self = (const struct arx *)model;
    double *age = state + 1, *last = state + 2, *drift = last + self->inputs;
    if (state[0] == 0.0) {
        state[0] = 1.0;
        for (size_t i = 0; i < self->inputs; i++) {
            last[i] = sample->inputs[i];
        }
    }
    *age += sample->elapsed_s;
    for (size_t target = 0; sample->measured != NULL && target < self->targets; target++) {
        drift[target] = sample->measured[target];
    }
    for (long count = clock_ticks(age, self->step_s); count > 0; count--) {
        tick(self, sample->inputs, last, drift);
    }
    for (size_t target = 0; target < self->targets; target++) {
        targets[target] = drift[target];
    }
}

const struct error_model_kind arx_kind = {"arx", make, NULL, predict};
