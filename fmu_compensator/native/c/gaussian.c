/* Weights, random walk and noise as one Gaussian, conditioned on the training. */
#include "gaussian.h"

#include <math.h>
#include <string.h>

#include "numbers.h"

#define WIDTH model_gaussian.width
#define INPUTS model_gaussian.inputs
#define PLACES (WIDTH + 1) /* of features, the 1 of the walk included */

static double *weights_of(struct gaussian_state *state)
{
    return state->features + PLACES;
}

static double *probes_of(struct gaussian_state *state)
{
    return state->features + PLACES * (1 + LANES);
}

size_t gaussian_states(void)
{
    return sizeof(struct gaussian_state) / sizeof(double) + PLACES * (1 + 2 * LANES);
}

void gaussian_make(struct setup *setup, struct gaussian *self)
{
    self->along = setup_take(setup, model_gaussian.tables * LANES, sizeof(double));
    self->column = setup_take(setup, PLACES, sizeof(double));
    self->direction = setup_take(setup, PLACES, sizeof(double));
    self->paces = setup_take(setup, 2 * model_gaussian.lags + 1, sizeof(double));
}

void gaussian_reset(struct gaussian_state *state)
{
    memset(state, 0, gaussian_states() * sizeof(double));
    state->hours = model_gaussian.settled_h;
    state->variance = state->left = 1.0;
    state->features[WIDTH] = 1.0;
    memcpy(weights_of(state), model_gaussian.weights, PLACES * LANES * sizeof(double));
    memcpy(state->added, model_gaussian.weights + WIDTH * LANES, LANES * sizeof(double));
}

/* Computes the sum of each lane. Each is in the order of the Python twin, but all at once:
   that is several times faster, and a compiler may do it so without changing a number. */
static void sums(const double *lanes, const double *features, double total[LANES])
{
    double a = 0.0, b = 0.0, c = 0.0, d = 0.0, e = 0.0, f = 0.0, g = 0.0, h = 0.0;
    for (size_t i = 0, count = PLACES; i < count; i++, lanes += LANES) {
        double value = features[i];
        a += value * lanes[0], b += value * lanes[1];
        c += value * lanes[2], d += value * lanes[3];
        e += value * lanes[4], f += value * lanes[5];
        g += value * lanes[6], h += value * lanes[7];
    }
    total[0] = a, total[1] = b, total[2] = c, total[3] = d;
    total[4] = e, total[5] = f, total[6] = g, total[7] = h;
}

bool gaussian_knows(double speed)
{
    return !GAUSSIAN_USES_SPEED || fabs(speed) <= GAUSSIAN_FASTEST * model_gaussian.speed_rpm;
}

/* Adds the speed until now and its square to the inputs of a sample. */
static void add_speed(
    struct gaussian_state *state, double *inputs, double elapsed_s, double speed)
{
    if (GAUSSIAN_USES_SPEED) {
        double *turning = inputs + model_chosen_count;
        /* A second look at the same sample, as for a probe, sees the same past. */
        turning[0] = elapsed_s > 0.0 ? state->speed / model_gaussian.speed_rpm
                                     : state->features[model_chosen_count];
        turning[1] = turning[0] * turning[0];
        state->speed = gaussian_knows(speed) ? fabs(speed) : state->speed;
    }
}

/* Computes the features of a sample: the inputs, then lag by lag. */
static void make_features(
    const struct gaussian *self, double *features, const double *inputs, double elapsed_s)
{
    double *last = features, *paces = self->paces;
    size_t lags = model_gaussian.lags;
    if (elapsed_s != paces[2 * lags]) {
        paces[2 * lags] = elapsed_s;
        for (size_t lag = 0; lag < lags; lag++) {
            paces[2 * lag] = lag_share(elapsed_s, model_gaussian.lags_s[lag]);
            paces[2 * lag + 1] = lag_behind(elapsed_s, model_gaussian.lags_s[lag]);
        }
    }
    for (size_t lag = 0; lag < lags; lag++) {
        double part = paces[2 * lag], late = paces[2 * lag + 1];
        features += INPUTS;
        for (size_t i = 0; i < INPUTS; i++) {
            features[i] += part * (inputs[i] - late * (inputs[i] - last[i]) - features[i]);
        }
    }
    memcpy(last, inputs, INPUTS * sizeof(double));
}

void gaussian_step(
    const struct gaussian *self, struct gaussian_state *state, double *inputs, double elapsed_s,
    double speed)
{
    const double *features = state->features;
    double along[LANES];
    state->hours += elapsed_s / 3600.0;
    add_speed(state, inputs, elapsed_s, speed);
    make_features(self, state->features, inputs, elapsed_s);
    double novelty = 0.0;
    for (size_t i = 0; i < WIDTH; i++) {
        novelty += model_gaussian.prior[i] * (features[i] * features[i]);
    }
    for (size_t row = 0; row < model_gaussian.tables * LANES; row += LANES) {
        sums(model_gaussian.seen + row * PLACES, features, self->along + row);
    }
    for (size_t row = 0; row < model_gaussian.tables * LANES; row++) {
        novelty -= self->along[row] * self->along[row];
    }
    state->novelty = novelty > 0.0 ? novelty : 0.0;
    double left = state->novelty + model_gaussian.walk_per_h * state->hours + state->leaps;
    sums(probes_of(state), features, along);
    for (size_t lane = 0; lane < LANES; lane++) {
        left -= along[lane] * along[lane];
    }
    state->left = left > 0.0 ? left : 0.0;
    state->variance = 1.0 + state->left;
    sums(weights_of(state), features, state->added);
}

double gaussian_usual_variance(const struct gaussian_state *state)
{
    return 1.0 + model_gaussian.walk_per_h * state->hours;
}

/* Subtracts from the column what the rows in lanes determine. */
static void narrow(const struct gaussian *self, const double *lanes, const double *along)
{
    for (size_t lane = 0; lane < LANES; lane++) {
        for (size_t i = 0; i < PLACES; i++) {
            self->column[i] -= along[lane] * lanes[i * LANES + lane];
        }
    }
}

/* Computes the covariance of the weights (after training) and of the walk with the last sample. */
static void make_column(
    const struct gaussian *self, const struct gaussian_state *state, double walked)
{
    for (size_t i = 0; i < WIDTH; i++) {
        self->column[i] = model_gaussian.prior[i] * state->features[i];
    }
    self->column[WIDTH] = walked;
    for (size_t row = 0; row < model_gaussian.tables * LANES; row += LANES) {
        narrow(self, model_gaussian.seen + row * PLACES, self->along + row);
    }
}

double gaussian_derive(
    const struct gaussian *self, struct gaussian_state *state, const double *rises, double *moved)
{
    double along[LANES], total[LANES], *direction = self->direction;
    for (size_t i = 0; i < WIDTH; i++) {
        const double *pace = self->paces + 2 * (i / INPUTS);
        double moves = i < INPUTS ? 1.0 : pace[-2] * (1.0 - pace[-1]);
        direction[i] = i % INPUTS < model_chosen_count ? moves * rises[i % INPUTS] : 0.0;
    }
    make_column(self, state, 0.0);
    double variance = state->novelty > 0.0 ? dot(self->column, direction, WIDTH) : 0.0;
    sums(probes_of(state), state->features, along);
    sums(probes_of(state), direction, total);
    variance -= dot(along, total, LANES);
    sums(weights_of(state), direction, total);
    for (size_t target = 0; target < model_target_count; target++) {
        moved[target] += total[target];
    }
    return state->left > 0.0 ? 2.0 * variance : 0.0;
}

/* A new row needs the last lane: all move by one, and the first, if in use, merges into the second.
   Rotating two rows in their plane does not change the variance. They are rotated so that one has
   no effect on this sample, and that one is dropped. */
static void condition(
    const struct gaussian *self, struct gaussian_state *state, const double *missed)
{
    double along[LANES], size = 1.0 + state->left, root = sqrt(size);
    double *weights = weights_of(state), *probes = probes_of(state);
    make_column(self, state, model_gaussian.walk_per_h * state->hours + state->leaps);
    sums(probes, state->features, along);
    narrow(self, probes, along);
    double a = along[0], b = along[1], length = sqrt(a * a + b * b);
    for (size_t i = 0; i < PLACES; i++, weights += LANES, probes += LANES) {
        for (size_t target = 0; target < model_target_count; target++) {
            weights[target] += self->column[i] * missed[target] / size;
        }
        probes[1] = a != 0.0 ? (a * probes[0] + b * probes[1]) / length : probes[1];
        memmove(probes, probes + 1, (LANES - 1) * sizeof(double));
        probes[LANES - 1] = self->column[i] / root;
    }
}

void gaussian_take(
    const struct gaussian *self, struct gaussian_state *state, const double *missed)
{
    const double *bias = weights_of(state) + WIDTH * LANES, *spread = model_gaussian.spread;
    double furthest = GAUSSIAN_FURTHEST * model_gaussian.deviations * sqrt(state->variance);
    double leap = 0.0;
    bool far = false, confirmed = state->suspected != 0.0;
    for (size_t target = 0; target < model_target_count; target++) {
        double limit = furthest * spread[target], over = missed[target] / spread[target];
        double whole = bias[target] + missed[target];
        far = far || fabs(missed[target]) > limit;
        confirmed = confirmed && !(fabs(whole - state->suspect[target]) > limit);
        leap = over * over > leap ? over * over : leap;
    }
    state->suspected = far && !confirmed;
    for (size_t target = 0; target < model_target_count; target++) {
        state->suspect[target] = state->suspected != 0.0 ? bias[target] + missed[target] : 0.0;
    }
    if (state->suspected != 0.0) {
        return;
    }
    if (far) {
        /* Confirmed: a joint has settled. Allow the walk a leap of this size. */
        state->leaps += leap;
        state->left += leap;
    }
    condition(self, state, missed);
}

size_t gaussian_culprits(
    const struct gaussian *self, const struct gaussian_state *state,
    size_t places[GAUSSIAN_NAMED])
{
    double *part = self->column, left = 0.5 * state->novelty;
    size_t count = 0, inputs = model_chosen_count;
    make_column(self, state, 0.0);
    /* Each input's parts are summed in its own place among the first. */
    for (size_t i = 0; i < WIDTH; i++) {
        double share = part[i] * state->features[i];
        part[i % INPUTS] = i < INPUTS ? share : part[i % INPUTS] + share;
    }
    if (GAUSSIAN_USES_SPEED) {
        part[inputs] += part[inputs + 1];
        inputs++;
    }
    while (count < GAUSSIAN_NAMED && count < inputs && (count == 0 || left > 0.0)) {
        size_t worst = 0;
        for (size_t i = 1; i < inputs; i++) {
            worst = part[i] > part[worst] ? i : worst;
        }
        places[count++] = worst;
        left -= part[worst];
        part[worst] = -INFINITY;
    }
    return count;
}
