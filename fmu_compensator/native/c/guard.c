/* A Bayesian ridge regression on few features, which knows where it knows nothing.

   State: started, the first readings, their starts, how far each lag has settled, the lagged rises
   lag by lag. */
#include "guard.h"

#include <math.h>

#include <string.h>

#include "numbers.h"

/* The parts of the state. */
struct memory {
    double *first, *starts, *settled, *lagged;
};

static struct memory memory_of(const struct guard *self, double *state)
{
    struct memory memory;
    memory.first = state + 1;
    memory.starts = memory.first + self->inputs;
    memory.settled = memory.starts + self->inputs;
    memory.lagged = memory.settled + self->lags;
    return memory;
}

/* Lays out the matrices as one row of weights per target, over: rises; per lag: lagged rises,
   starts. */
static void make_weights(struct setup *setup, const struct field *table, struct guard *self)
{
    const double *direct = field_matrix(setup, table, "direct", NULL);
    const struct field *rise_lags = field_list(setup, table, "rise_lags", NULL);
    const struct field *start_lags = field_list(setup, table, "start_lags", NULL);
    size_t inputs = self->inputs, size = inputs * sizeof(double);
    self->weights = setup_take(setup, self->targets * self->width, sizeof(double));
    if (setup->problem != NULL) {
        return;
    }
    for (size_t target = 0; target < self->targets; target++) {
        double *row = self->weights + target * self->width;
        memcpy(row, direct + target * inputs, size);
        for (size_t lag = 0; lag < self->lags; lag++) {
            row += inputs;
            memcpy(row, rise_lags[lag].numbers + target * inputs, size);
            row += inputs;
            memcpy(row, start_lags[lag].numbers + target * inputs, size);
        }
    }
}

struct guard *guard_make(
    struct setup *setup, const struct field *table, size_t inputs, size_t targets)
{
    if (table->form == FIELD_NULL) {
        return NULL;
    }
    struct guard *self = setup_take(setup, 1, sizeof *self);
    if (self == NULL) {
        return NULL;
    }
    self->inputs = inputs;
    self->targets = targets;
    self->lags_s = field_numbers(setup, table, "lags_s", &self->lags);
    self->width = inputs * (1 + 2 * self->lags);
    self->states = 1 + 2 * inputs + self->lags * (1 + inputs);
    self->fixed = strcmp(field_text(setup, table, "reference"), "fixed") == 0;
    self->usual = field_numbers(setup, table, "usual", NULL);
    self->constant = field_numbers(setup, table, "constant", NULL);
    self->seen = field_matrix(setup, table, "seen", &self->directions);
    self->leash = field_numbers(setup, table, "leash", NULL);
    self->prior = field_number(setup, table, "prior");
    self->known = field_number(setup, table, "known");
    field_axes(setup, table, "fade_shortest", 0.0, self->fade_shortest);
    field_axes(setup, table, "fade_longest", 0.0, self->fade_longest);
    self->features = setup_take(setup, self->width, sizeof(double));
    self->shares = setup_take(setup, self->width, sizeof(double));
    self->rises = setup_take(setup, inputs, sizeof(double));
    self->sorted = setup_take(setup, inputs, sizeof(double));
    self->part = setup_take(setup, inputs, sizeof(double));
    make_weights(setup, table, self);
    return self;
}

/* A lone sensor with a wrong level counts as at its usual place. */
static void believe(double *starts, size_t count)
{
    double furthest = 0.0, next = 0.0;
    for (size_t i = 0; i < count; i++) {
        double away = fabs(starts[i]);
        if (away > furthest) {
            next = furthest;
            furthest = away;
        } else if (away > next) {
            next = away;
        }
    }
    if (count < 2 || !(furthest > GUARD_LEVEL_FAULT_K && furthest > GUARD_LONE * next)) {
        return;
    }
    for (size_t i = 0; i < count; i++) {
        if (fabs(starts[i]) == furthest) {
            starts[i] = 0.0;
        }
    }
}

static void begin(const struct guard *self, struct memory *memory, const double *readings)
{
    double middle = median(readings, self->inputs, self->sorted);
    for (size_t i = 0; i < self->inputs; i++) {
        memory->first[i] = self->fixed ? self->usual[i] : readings[i];
        memory->starts[i] = self->fixed ? 0.0 : readings[i] - middle - self->usual[i];
    }
    believe(memory->starts, self->inputs);
}

/* Puts down the features of a sample: the rises; per lag: lagged rises, starts. */
static void make_features(const struct guard *self, struct memory *memory, double elapsed_s)
{
    size_t inputs = self->inputs;
    double *features = self->features, *lagged = memory->lagged;
    memcpy(features, self->rises, inputs * sizeof(double));
    for (size_t lag = 0; lag < self->lags; lag++) {
        double part = lag_share(elapsed_s, self->lags_s[lag]);
        double *weight = &memory->settled[lag];
        *weight += part * (1.0 - *weight);
        features += inputs;
        for (size_t i = 0; i < inputs; i++) {
            lagged[i] += part * (self->rises[i] - lagged[i]);
            features[i] = lagged[i];
        }
        features += inputs;
        for (size_t i = 0; i < inputs; i++) {
            features[i] = *weight * memory->starts[i];
        }
        lagged += inputs;
    }
}

double guard_usual_start(const struct guard *self, size_t place, double middle)
{
    return self->fixed ? NAN : middle + self->usual[place];
}

double guard_step(
    const struct guard *self, double *state, const double *readings, double elapsed_s,
    double *careful)
{
    struct memory memory = memory_of(self, state);
    const double *features = self->features;
    if (state[0] == 0.0) {
        state[0] = 1.0;
        begin(self, &memory, readings);
        elapsed_s = 0.0;
    }
    for (size_t i = 0; i < self->inputs; i++) {
        self->rises[i] = readings[i] - memory.first[i];
    }
    make_features(self, &memory, elapsed_s);
    double novelty = self->prior * dot(features, features, self->width);
    for (size_t row = 0; row < self->directions; row++) {
        double along = dot(self->seen + row * self->width, features, self->width);
        novelty -= along * along;
    }
    for (size_t target = 0; target < self->targets; target++) {
        const double *weights = self->weights + target * self->width;
        careful[target] = self->constant[target] + dot(weights, features, self->width);
    }
    return novelty < 0.0 ? 0.0 : novelty;
}

void guard_hold(const struct guard *self, double *targets, const double *careful)
{
    for (size_t target = 0; target < self->targets; target++) {
        double safe = careful[target], leash = self->leash[target];
        targets[target] = clamped(targets[target], safe - leash, safe + leash);
    }
}

double guard_faded(
    const struct guard *self, size_t axis, double novelty, double tool_share, double doubt)
{
    double shortest = self->fade_shortest[axis], longest = self->fade_longest[axis];
    double beyond = novelty - self->known;
    if (beyond <= 0.0) {
        return 1.0;
    }
    return 1.0 / (1.0 + (shortest + tool_share * (longest - shortest)) * beyond * doubt);
}

/* Puts down what each input brings to the novelty of the last sample. */
static void make_parts(const struct guard *self)
{
    for (size_t i = 0; i < self->width; i++) {
        self->shares[i] = self->prior * self->features[i];
    }
    for (size_t row = 0; row < self->directions; row++) {
        const double *direction = self->seen + row * self->width;
        double along = dot(direction, self->features, self->width);
        for (size_t i = 0; i < self->width; i++) {
            self->shares[i] -= along * direction[i];
        }
    }
    memset(self->part, 0, self->inputs * sizeof(double));
    for (size_t i = 0; i < self->width; i++) {
        self->part[i % self->inputs] += self->shares[i] * self->features[i];
    }
}

static bool among(const size_t *places, size_t count, size_t place)
{
    for (size_t i = 0; i < count; i++) {
        if (places[i] == place) {
            return true;
        }
    }
    return false;
}

size_t guard_culprits(const struct guard *self, double novelty, size_t places[GUARD_CULPRITS])
{
    size_t count = 0;
    make_parts(self);
    while (count < GUARD_CULPRITS && count < self->inputs) {
        size_t worst = self->inputs;
        for (size_t i = 0; i < self->inputs; i++) {
            if (!among(places, count, i)
                && (worst == self->inputs || self->part[i] > self->part[worst])) {
                worst = i;
            }
        }
        if (count > 0 && self->part[worst] < GUARD_CULPRIT_SHARE * novelty) {
            break;
        }
        places[count++] = worst;
    }
    return count;
}
