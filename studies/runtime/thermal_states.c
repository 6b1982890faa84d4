/* Weighted sum of rises, lagged rises, lagged levels and lagged speeds.

   State: started, the speed at the previous sample [1000 rpm], the first inputs, their shifts,
   then the lagged values of each lag: rises, levels, speed and its square. */
#include <math.h>
#include <string.h>

#include "../constants.h"
#include "../error_model.h"
#include "../numbers.h"

struct lag {
    double tau_s;
    const double *rises, *levels, *speeds; /* weights, row by row */
};

struct thermal_states {
    struct error_model base;
    size_t inputs, targets, lags;
    const double *start_low, *start_usual, *start_high, *direct;
    struct lag *lag;
    double *rises, *levels, *sorted; /* of one sample */
};

/* The parts of the state. */
struct memory {
    double *speed, *first, *shift, *lagged;
};

static struct memory memory_of(const struct thermal_states *self, double *state)
{
    struct memory memory;
    memory.speed = state + 1;
    memory.first = state + 2;
    memory.shift = memory.first + self->inputs;
    memory.lagged = memory.shift + self->inputs;
    return memory;
}

static const double *matrix(const struct field *matrices, size_t place)
{
    return matrices == NULL ? NULL : matrices[place].numbers;
}

static void make_lags(struct setup *setup, const struct field *table, struct thermal_states *self)
{
    const double *taus = field_numbers(setup, table, "lags_s", &self->lags);
    const struct field *rises = field_list(setup, table, "rise_lags", NULL);
    const struct field *levels = field_list(setup, table, "level_lags", NULL);
    const struct field *speeds = field_list(setup, table, "speed_lags", NULL);
    self->lag = setup_take(setup, self->lags, sizeof *self->lag);
    for (size_t i = 0; self->lag != NULL && i < self->lags; i++) {
        self->lag[i].tau_s = taus[i];
        self->lag[i].rises = matrix(rises, i);
        self->lag[i].levels = matrix(levels, i);
        self->lag[i].speeds = matrix(speeds, i);
    }
}

static struct error_model *make(
    struct setup *setup, const struct field *table, size_t inputs, size_t targets)
{
    struct thermal_states *self = setup_take(setup, 1, sizeof *self);
    if (self == NULL) {
        return NULL;
    }
    self->inputs = inputs;
    self->targets = targets;
    self->start_low = field_numbers(setup, table, "start_low", NULL);
    self->start_usual = field_numbers(setup, table, "start_usual", NULL);
    self->start_high = field_numbers(setup, table, "start_high", NULL);
    self->direct = field_matrix(setup, table, "direct", NULL);
    make_lags(setup, table, self);
    self->rises = setup_take(setup, inputs, sizeof(double));
    self->levels = setup_take(setup, inputs, sizeof(double));
    self->sorted = setup_take(setup, inputs, sizeof(double));
    self->base.states = 2 + 2 * inputs + self->lags * (2 * inputs + 2);
    return &self->base;
}

/* Subtracts the median of all values from each. */
static void take_levels(const struct thermal_states *self, double *values)
{
    double middle = median(values, self->inputs, self->sorted);
    for (size_t i = 0; i < self->inputs; i++) {
        values[i] -= middle;
    }
}

/* Stores the first inputs, and shifts a level outside the range seen at the start in training. */
static void start(const struct thermal_states *self, struct memory *memory, const double *inputs)
{
    for (size_t i = 0; i < self->inputs; i++) {
        memory->first[i] = self->levels[i] = inputs[i];
    }
    take_levels(self, self->levels);
    for (size_t i = 0; i < self->inputs; i++) {
        double level = self->levels[i];
        int usual = self->start_low[i] <= level && level <= self->start_high[i];
        memory->shift[i] = usual ? 0.0 : self->start_usual[i] - level;
    }
}

static void follow(double *values, size_t count, double part, const double *drives)
{
    for (size_t i = 0; i < count; i++) {
        values[i] += part * (drives[i] - values[i]);
    }
}

/* Adds the products one by one, in the order of the Python twin. */
static double added(double total, const double *weights, const double *values, size_t count)
{
    for (size_t i = 0; i < count; i++) {
        total += weights[i] * values[i];
    }
    return total;
}

static double weighted(const struct thermal_states *self, const double *lagged, size_t target)
{
    size_t inputs = self->inputs;
    double total = added(0.0, self->direct + target * inputs, self->rises, inputs);
    for (size_t i = 0; i < self->lags; i++) {
        const double *values = lagged + i * (2 * inputs + 2);
        total = added(total, self->lag[i].rises + target * inputs, values, inputs);
        total = added(total, self->lag[i].levels + target * inputs, values + inputs, inputs);
        total = added(total, self->lag[i].speeds + target * 2, values + 2 * inputs, 2);
    }
    return total;
}

static void predict(
    const struct error_model *model, double *state, const struct sample *sample, double *targets)
{
    const struct thermal_states *self = (const struct thermal_states *)model;
    struct memory memory = memory_of(self, state);
    size_t inputs = self->inputs;
    if (state[0] == 0.0) {
        state[0] = 1.0;
        start(self, &memory, sample->inputs);
    }
    for (size_t i = 0; i < inputs; i++) {
        self->rises[i] = sample->inputs[i] - memory.first[i];
        self->levels[i] = sample->inputs[i] + memory.shift[i];
    }
    take_levels(self, self->levels);
    double speeds[2] = {*memory.speed, *memory.speed * *memory.speed};
    for (size_t i = 0; i < self->lags; i++) {
        double part = lag_share(sample->elapsed_s, self->lag[i].tau_s);
        double *values = memory.lagged + i * (2 * inputs + 2);
        follow(values, inputs, part, self->rises);
        follow(values + inputs, inputs, part, self->levels);
        follow(values + 2 * inputs, 2, part, speeds);
    }
    *memory.speed = known_speed(sample->speed, *memory.speed * THERMAL_STATES_SPEED_UNIT)
                    / THERMAL_STATES_SPEED_UNIT;
    for (size_t target = 0; target < self->targets; target++) {
        targets[target] = weighted(self, memory.lagged, target);
    }
}

const struct error_model_kind thermal_states_kind = {"thermal_states", make, NULL, predict};
/* These are fitted differently but run like thermal states. */
const struct error_model_kind bayes_kind = {"bayes", make, NULL, predict};
const struct error_model_kind lasso_kind = {"lasso", make, NULL, predict};
const struct error_model_kind ridge_kind = {"ridge", make, NULL, predict};
