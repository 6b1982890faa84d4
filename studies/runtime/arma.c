/* Time series: w = (difference of order d of y - mean) / scale is an ARMA(p, q), per target.

   State: measurement waiting to be used, age of the step [s], the measured targets; then
   for each series: held value, whether the last step was measured, last value of each lower-order
   difference, past w, past errors. */
#include "../constants.h"
#include "../error_model.h"
#include "../numbers.h"

struct series {
    double mean, scale;
    size_t tails, past, errors;
    const double *ar, *ma;
};

struct arma {
    struct error_model base;
    size_t targets;
    double step_s;
    struct series *series;
};

/* One series' part of the state. */
struct memory {
    double *held, *synced, *tails, *past, *errors, *end;
};

static struct memory memory_of(const struct series *series, double *state)
{
    struct memory memory = {state, state + 1, state + 2, NULL, NULL, NULL};
    memory.past = memory.tails + series->tails;
    memory.errors = memory.past + series->past;
    memory.end = memory.errors + series->errors;
    return memory;
}

static struct error_model *make(
    struct setup *setup, const struct field *table, size_t inputs, size_t targets)
{
    struct arma *self = setup_take(setup, 1, sizeof *self);
    size_t count = 0;
    (void)inputs;
    if (self == NULL) {
        return NULL;
    }
    self->targets = targets;
    self->step_s = field_number(setup, table, "step_s");
    self->series = setup_take(setup, targets, sizeof *self->series);
    const struct field *tables = field_list(setup, table, "series", &count);
    if (self->series == NULL || count != targets) {
        return NULL;
    }
    self->base.states = 2 + targets;
    for (size_t target = 0; target < targets; target++) {
        struct series *one = &self->series[target];
        one->mean = field_number(setup, &tables[target], "mean");
        one->scale = field_number(setup, &tables[target], "scale");
        one->tails = (size_t)field_number(setup, &tables[target], "differences");
        one->ar = field_numbers(setup, &tables[target], "ar", &one->past);
        one->ma = field_numbers(setup, &tables[target], "ma", &one->errors);
        self->base.states += 2 + one->tails + one->past + one->errors;
    }
    return &self->base;
}

static void reset(const struct error_model *model, double *state)
{
    const struct arma *self = (const struct arma *)model;
    double *own = state + 2 + self->targets;
    state[0] = 1.0; /* the first sample measures zero */
    for (size_t target = 0; target < self->targets; target++) {
        struct memory memory = memory_of(&self->series[target], own);
        *memory.synced = 1.0;
        own = memory.end;
    }
}

static double limited(double value)
{
    return clamped(value, -FIELDS_LARGEST, FIELDS_LARGEST);
}

static double forecast(const struct series *one, const struct memory *memory)
{
    return dot(one->ar, memory->past, one->past) + dot(one->ma, memory->errors, one->errors);
}

static double level(const struct series *one, const struct memory *memory, double w)
{
    double value = one->mean + one->scale * w;
    for (size_t i = 0; i < one->tails; i++) {
        value += memory->tails[i];
    }
    return limited(value);
}

static void push(double *row, size_t count, double value)
{
    for (size_t i = count; i-- > 1;) {
        row[i] = row[i - 1];
    }
    if (count > 0) {
        row[0] = limited(value);
    }
}

/* Advances by one step, with its measurement or with the forecast. */
static void take(const struct series *one, struct memory *memory, const double *measured)
{
    double expected = forecast(one, memory);
    double w = expected;
    double reached = level(one, memory, expected);
    if (measured != NULL) {
        if (*memory->synced != 0.0 || one->tails == 0) {
            double tails = 0.0;
            for (size_t i = 0; i < one->tails; i++) {
                tails += memory->tails[i];
            }
            w = (*measured - tails - one->mean) / one->scale;
        }
        /* After steps without measurement, the whole error would look like one step's jump. */
        reached = *measured;
    }
    double rate = limited(one->mean + one->scale * w);
    if (one->tails == 2) {
        memory->tails[1] = limited(memory->tails[1] + rate);
    }
    if (one->tails > 0) {
        memory->tails[0] = reached;
    }
    push(memory->past, one->past, w);
    push(memory->errors, one->errors, w - expected);
    *memory->synced = measured != NULL;
    *memory->held = level(one, memory, forecast(one, memory));
}

static void predict(
    const struct error_model *model, double *state, const struct sample *sample, double *targets)
{
    const struct arma *self = (const struct arma *)model;
    double *waiting = state, *age = state + 1, *measured = state + 2;
    *age += sample->elapsed_s;
    if (sample->measured != NULL) {
        *waiting = 1.0;
        for (size_t target = 0; target < self->targets; target++) {
            measured[target] = sample->measured[target];
        }
    }
    long count = clock_ticks(age, self->step_s);
    for (long tick = 0; tick < count; tick++) {
        double *own = measured + self->targets;
        for (size_t target = 0; target < self->targets; target++) {
            struct memory memory = memory_of(&self->series[target], own);
            take(&self->series[target], &memory, *waiting != 0.0 ? &measured[target] : NULL);
            own = memory.end;
        }
        *waiting = 0.0;
    }
    double *own = measured + self->targets;
    for (size_t target = 0; target < self->targets; target++) {
        struct memory memory = memory_of(&self->series[target], own);
        targets[target] = *memory.held;
        own = memory.end;
    }
}

const struct error_model_kind arma_kind = {"arma", make, reset, predict};
