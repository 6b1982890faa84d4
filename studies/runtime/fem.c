/* The finite-element spindle, reduced to a few thermal modes per regime of speed.

   State: started, the speed at the previous sample [r/min], the first and the last outside
   temperatures, then the coordinates of each drive: heat sources, then outside temperatures. */
#include <math.h>

#include "../error_model.h"
#include "../numbers.h"

struct regime {
    double speed;
    const double *rates, *vectors, *outside;
};

struct source {
    double viscous, threshold, slow, load;
    const double *entry;
};

struct fem {
    struct error_model base;
    size_t targets, modes, outsides, regimes, sources;
    const double *outside_inputs, *intercept, *outputs;
    struct regime *regime;
    struct source *source;
    double *decay, *gain, *amplitude; /* of each mode */
};

static void make_regimes(struct setup *setup, const struct field *table, struct fem *self)
{
    const struct field *tables = field_list(setup, table, "regimes", &self->regimes);
    self->regime = setup_take(setup, self->regimes, sizeof *self->regime);
    for (size_t i = 0; self->regime != NULL && i < self->regimes; i++) {
        self->regime[i].speed = field_number(setup, &tables[i], "speed");
        self->regime[i].rates = field_numbers(setup, &tables[i], "rates", NULL);
        self->regime[i].vectors = field_matrix(setup, &tables[i], "vectors", NULL);
        self->regime[i].outside = field_matrix(setup, &tables[i], "outside", NULL);
    }
}

static void make_sources(struct setup *setup, const struct field *table, struct fem *self)
{
    const struct field *tables = field_list(setup, table, "sources", &self->sources);
    self->source = setup_take(setup, self->sources, sizeof *self->source);
    for (size_t i = 0; self->source != NULL && i < self->sources; i++) {
        self->source[i].viscous = field_number(setup, &tables[i], "viscous");
        self->source[i].threshold = field_number(setup, &tables[i], "threshold");
        self->source[i].slow = field_number(setup, &tables[i], "slow");
        self->source[i].load = field_number(setup, &tables[i], "load");
        self->source[i].entry = field_numbers(setup, &tables[i], "entry", NULL);
    }
}

static struct error_model *make(
    struct setup *setup, const struct field *table, size_t inputs, size_t targets)
{
    struct fem *self = setup_take(setup, 1, sizeof *self);
    (void)inputs;
    if (self == NULL) {
        return NULL;
    }
    self->targets = targets;
    self->modes = (size_t)field_number(setup, table, "states");
    self->outside_inputs = field_numbers(setup, table, "outside_inputs", &self->outsides);
    self->intercept = field_numbers(setup, table, "intercept", NULL);
    self->outputs = field_matrix(setup, table, "outputs", NULL);
    make_regimes(setup, table, self);
    make_sources(setup, table, self);
    self->decay = setup_take(setup, self->modes, sizeof(double));
    self->gain = setup_take(setup, self->modes, sizeof(double));
    self->amplitude = setup_take(setup, self->modes, sizeof(double));
    self->base.states = 2 + 2 * self->outsides + self->modes * (self->sources + self->outsides);
    return &self->base;
}

/* Heat at speed n: viscous n^(5/3) + load n; below the threshold slow n + load n [W]. */
static double power(const struct source *source, double speed)
{
    double churning = source->slow * speed;
    if (speed >= source->threshold) {
        churning = source->viscous * pow(speed, 5.0 / 3.0);
    }
    return churning + source->load * speed;
}

/* Advances the coordinates of one drive; its forcing is strength times the pattern. */
static void drive(
    const struct fem *self, const struct regime *regime, double *state, double strength,
    const double *pattern)
{
    for (size_t mode = 0; mode < self->modes; mode++) {
        double place = 0.0, force = 0.0;
        for (size_t i = 0; i < self->modes; i++) {
            double weight = regime->vectors[i * self->modes + mode];
            place += weight * state[i];
            force += weight * (strength * pattern[i]);
        }
        self->amplitude[mode] = self->decay[mode] * place + self->gain[mode] * force;
    }
    for (size_t i = 0; i < self->modes; i++) {
        state[i] = dot(regime->vectors + i * self->modes, self->amplitude, self->modes);
    }
}

static const struct regime *regime_at(const struct fem *self, double speed)
{
    size_t place = 0;
    while (place + 1 < self->regimes
           && speed > (self->regime[place].speed + self->regime[place + 1].speed) / 2.0) {
        place++;
    }
    return &self->regime[place];
}

static void advance(
    const struct fem *self, double *state, const struct sample *sample, double *states)
{
    double speed = state[1];
    const double *first = state + 2, *last = first + self->outsides;
    const struct regime *regime = regime_at(self, speed);
    for (size_t mode = 0; mode < self->modes; mode++) {
        double rate = regime->rates[mode];
        self->decay[mode] = exp(-rate * sample->elapsed_s);
        self->gain[mode] = -expm1(-rate * sample->elapsed_s) / rate;
    }
    for (size_t i = 0; i < self->sources; i++) {
        const struct source *source = &self->source[i];
        drive(self, regime, states + i * self->modes, power(source, speed), source->entry);
    }
    for (size_t i = 0; i < self->outsides; i++) {
        double now = sample->inputs[(size_t)self->outside_inputs[i]];
        double rise = (now + last[i]) / 2.0 - first[i];
        double *own = states + (self->sources + i) * self->modes;
        drive(self, regime, own, rise, regime->outside + i * self->modes);
    }
}

static void predict(
    const struct error_model *model, double *state, const struct sample *sample, double *targets)
{
    const struct fem *self = (const struct fem *)model;
    double *first = state + 2, *last = first + self->outsides, *states = last + self->outsides;
    size_t width = self->modes * (self->sources + self->outsides);
    if (state[0] == 0.0) {
        state[0] = 1.0;
        for (size_t i = 0; i < self->outsides; i++) {
            first[i] = sample->inputs[(size_t)self->outside_inputs[i]];
        }
    } else if (sample->elapsed_s > 0.0) {
        advance(self, state, sample, states);
    }
    for (size_t i = 0; i < self->outsides; i++) {
        last[i] = sample->inputs[(size_t)self->outside_inputs[i]];
    }
    state[1] = known_speed(sample->speed, state[1]);
    for (size_t target = 0; target < self->targets; target++) {
        const double *weights = self->outputs + target * width;
        targets[target] = self->intercept[target] + dot(weights, states, width);
    }
}

const struct error_model_kind fem_kind = {"fem", make, NULL, predict};
