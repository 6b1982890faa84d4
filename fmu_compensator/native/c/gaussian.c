/* Weights, random walk and noise as one Gaussian, conditioned on the training. */
#include "gaussian.h"

#include <math.h>
#include <string.h>

#include "numbers.h"

struct gaussian_state gaussian_state(const struct gaussian *self, double *state)
{
    struct gaussian_state at;
    at.hours = state;
    at.leaps = state + 1;
    at.novelty = state + 2;
    at.variance = state + 3;
    at.left = state + 4;
    at.suspected = state + 5;
    at.features = state + 6;
    at.bias = at.features + self->width;
    at.added = at.bias + self->targets;
    at.suspect = at.added + self->targets;
    at.weights = at.suspect + self->targets;
    at.probes = at.weights + self->width * LANES;
    return at;
}

static double *made(struct setup *setup, size_t count)
{
    return setup_take(setup, count, sizeof(double));
}

void gaussian_make(
    struct setup *setup, const struct field *table, size_t inputs, size_t targets,
    struct gaussian *self)
{
    self->inputs = inputs;
    self->targets = targets;
    self->lags_s = field_numbers(setup, table, "lags_s", &self->lags);
    self->width = inputs * (1 + self->lags);
    self->states = 6 + self->width + 3 * targets + (2 * self->width + 1) * LANES;
    self->fixed = strcmp(field_text(setup, table, "reference"), "fixed") == 0;
    self->usual = self->fixed ? field_numbers(setup, table, "usual", NULL) : NULL;
    self->constant = field_numbers(setup, table, "constant", NULL);
    self->settled_h = field_number(setup, table, "settled_h");
    self->weights = field_matrix(setup, table, "weights", NULL);
    self->scale = field_number(setup, table, "scale");
    self->seen = field_matrix(setup, table, "seen", &self->directions);
    self->walk_per_h = field_number(setup, table, "walk_per_h");
    self->spread = field_numbers(setup, table, "spread", NULL);
    self->deviations = field_number(setup, table, "deviations");
    size_t tables = (self->directions + LANES - 1) / LANES;
    self->lanes = made(setup, tables * self->width * LANES);
    self->along = made(setup, tables * LANES);
    self->column = made(setup, self->width);
    self->direction = made(setup, self->width);
    self->shares = made(setup, self->lags + 1);
    if (targets > LANES) {
        setup_fail(setup, "the compiled-in file predicts too many", "targets");
    }
    for (size_t row = 0; setup->problem == NULL && row < self->directions; row++) {
        double *lane = self->lanes + row / LANES * self->width * LANES + row % LANES;
        for (size_t i = 0; i < self->width; i++) {
            lane[i * LANES] = self->seen[row * self->width + i];
        }
    }
}

void gaussian_reset(const struct gaussian *self, double *state)
{
    struct gaussian_state at = gaussian_state(self, state);
    memset(state, 0, self->states * sizeof(double));
    *at.hours = self->settled_h;
    *at.variance = *at.left = 1.0;
    for (size_t target = 0; target < self->targets; target++) {
        at.bias[target] = at.added[target] = self->constant[target];
        for (size_t i = 0; i < self->width; i++) {
            at.weights[i * LANES + target] = self->weights[target * self->width + i];
        }
    }
}

/* Puts down the sum of each lane. Each is made in the order of the Python twin, but all at once:
   that is several times faster, and a compiler may do it so without changing a number. */
static void sums(const double *lanes, const double *features, size_t width, double total[LANES])
{
    double a = 0.0, b = 0.0, c = 0.0, d = 0.0, e = 0.0, f = 0.0, g = 0.0, h = 0.0;
    for (size_t i = 0; i < width; i++, lanes += LANES) {
        double value = features[i];
        a += value * lanes[0];
        b += value * lanes[1];
        c += value * lanes[2];
        d += value * lanes[3];
        e += value * lanes[4];
        f += value * lanes[5];
        g += value * lanes[6];
        h += value * lanes[7];
    }
    total[0] = a, total[1] = b, total[2] = c, total[3] = d;
    total[4] = e, total[5] = f, total[6] = g, total[7] = h;
}

/* Puts down how far the features go along each measurement that still counts [1]. */
static void along_probes(
    const struct gaussian *self, const struct gaussian_state *at, double along[LANES])
{
    const double *walk = at->probes + self->width * LANES;
    sums(at->probes, at->features, self->width, along);
    for (size_t lane = 0; lane < LANES; lane++) {
        along[lane] += walk[lane];
    }
}

/* Puts down the features of a sample: the rises, then lag by lag. */
static void make_features(
    const struct gaussian *self, double *features, const double *rises, double elapsed_s)
{
    double *known_s = &self->shares[self->lags];
    if (elapsed_s != *known_s) {
        *known_s = elapsed_s;
        for (size_t lag = 0; lag < self->lags; lag++) {
            self->shares[lag] = lag_share(elapsed_s, self->lags_s[lag]);
        }
    }
    memcpy(features, rises, self->inputs * sizeof(double));
    for (size_t lag = 0; lag < self->lags; lag++) {
        double part = self->shares[lag];
        features += self->inputs;
        for (size_t i = 0; i < self->inputs; i++) {
            features[i] += part * (rises[i] - features[i]);
        }
    }
}

static double walk(const struct gaussian *self, const struct gaussian_state *at)
{
    return self->walk_per_h * *at->hours;
}

void gaussian_step(
    const struct gaussian *self, double *state, const double *rises, double elapsed_s)
{
    struct gaussian_state at = gaussian_state(self, state);
    double total[LANES];
    *at.hours += elapsed_s / 3600.0;
    make_features(self, at.features, rises, elapsed_s);
    double novelty = self->scale * dot(at.features, at.features, self->width);
    for (size_t row = 0; row < self->directions; row += LANES) {
        sums(self->lanes + row * self->width, at.features, self->width, self->along + row);
    }
    for (size_t row = 0; row < self->directions; row++) {
        novelty -= self->along[row] * self->along[row];
    }
    *at.novelty = novelty > 0.0 ? novelty : 0.0;
    double left = *at.novelty + walk(self, &at) + *at.leaps;
    along_probes(self, &at, total);
    for (size_t lane = 0; lane < LANES; lane++) {
        left -= total[lane] * total[lane];
    }
    *at.left = left > 0.0 ? left : 0.0;
    *at.variance = 1.0 + *at.left;
    sums(at.weights, at.features, self->width, total);
    for (size_t target = 0; target < self->targets; target++) {
        at.added[target] = at.bias[target] + total[target];
    }
}

double gaussian_usual_variance(const struct gaussian *self, double *state)
{
    struct gaussian_state at = gaussian_state(self, state);
    return 1.0 + walk(self, &at);
}

/* Puts down the covariance of the weights, as training left it, with the last sample. */
static void make_column(const struct gaussian *self, const double *features)
{
    const double *row = self->seen;
    for (size_t i = 0; i < self->width; i++) {
        self->column[i] = self->scale * features[i];
    }
    for (size_t k = 0; k < self->directions; k++, row += self->width) {
        for (size_t i = 0; i < self->width; i++) {
            self->column[i] -= self->along[k] * row[i];
        }
    }
}

double gaussian_derive(
    const struct gaussian *self, double *state, const double *rises, double *moved)
{
    struct gaussian_state at = gaussian_state(self, state);
    double along[LANES], total[LANES], *direction = self->direction;
    for (size_t i = 0; i < self->width; i++) {
        size_t lag = i / self->inputs;
        direction[i] = (lag == 0 ? 1.0 : self->shares[lag - 1]) * rises[i % self->inputs];
    }
    make_column(self, at.features);
    double variance = *at.novelty > 0.0 ? dot(self->column, direction, self->width) : 0.0;
    along_probes(self, &at, along);
    sums(at.probes, direction, self->width, total);
    variance -= dot(along, total, LANES);
    sums(at.weights, direction, self->width, total);
    for (size_t target = 0; target < self->targets; target++) {
        moved[target] += total[target];
    }
    return *at.left > 0.0 ? 2.0 * variance : 0.0;
}

/* Frees the last lane: all move by one, and the first, if it is in use, goes into the second. Two
   rows turned in their plane narrow as much as before. Turned so that one of them says nothing of
   this sample, that one may go. */
static void turn_oldest(const struct gaussian *self, double *probes, double a, double b)
{
    size_t count = (self->width + 1) * LANES;
    for (size_t i = 0; a != 0.0 && i < count; i += LANES) {
        probes[i + 1] = (a * probes[i] + b * probes[i + 1]) / sqrt(a * a + b * b);
    }
    memmove(probes, probes + 1, (count - 1) * sizeof(double));
}

static void condition(
    const struct gaussian *self, const struct gaussian_state *at, const double *missed)
{
    double along[LANES], size = 1.0 + *at->left, root = sqrt(size);
    double *last = at->probes + self->width * LANES, moved = walk(self, at) + *at->leaps;
    make_column(self, at->features);
    along_probes(self, at, along);
    for (size_t lane = 0; lane < LANES; lane++) {
        for (size_t i = 0; i < self->width; i++) {
            self->column[i] -= along[lane] * at->probes[i * LANES + lane];
        }
        moved -= along[lane] * last[lane];
    }
    for (size_t target = 0; target < self->targets; target++) {
        for (size_t i = 0; i < self->width; i++) {
            at->weights[i * LANES + target] += self->column[i] * missed[target] / size;
        }
        at->bias[target] += moved * missed[target] / size;
    }
    turn_oldest(self, at->probes, along[0], along[1]);
    for (size_t i = 0; i < self->width; i++) {
        at->probes[i * LANES + LANES - 1] = self->column[i] / root;
    }
    last[LANES - 1] = moved / root;
}

void gaussian_take(const struct gaussian *self, double *state, const double *missed)
{
    struct gaussian_state at = gaussian_state(self, state);
    double furthest = GAUSSIAN_FURTHEST * self->deviations * sqrt(*at.variance), leap = 0.0;
    bool far = false, confirmed = *at.suspected != 0.0;
    for (size_t target = 0; target < self->targets; target++) {
        double limit = furthest * self->spread[target];
        double over = missed[target] / self->spread[target];
        double whole = at.bias[target] + missed[target];
        far = far || fabs(missed[target]) > limit;
        confirmed = confirmed && !(fabs(whole - at.suspect[target]) > limit);
        leap = over * over > leap ? over * over : leap;
    }
    *at.suspected = far && !confirmed;
    for (size_t target = 0; target < self->targets; target++) {
        at.suspect[target] = *at.suspected != 0.0 ? at.bias[target] + missed[target] : 0.0;
    }
    if (*at.suspected != 0.0) {
        return;
    }
    if (far) {
        /* Seen twice: a joint settled. The walk may have leapt by as much. */
        *at.leaps += leap;
        *at.left += leap;
    }
    condition(self, &at, missed);
}

size_t gaussian_culprits(
    const struct gaussian *self, double *state, size_t places[GAUSSIAN_NAMED])
{
    struct gaussian_state at = gaussian_state(self, state);
    double *part = self->column, left = 0.5 * *at.novelty;
    size_t count = 0;
    make_column(self, at.features);
    /* Each input's part is gathered where its rise's part was. */
    for (size_t i = 0; i < self->width; i++) {
        double share = self->column[i] * at.features[i];
        part[i % self->inputs] = i < self->inputs ? share : part[i % self->inputs] + share;
    }
    while (count < GAUSSIAN_NAMED && count < self->inputs && (count == 0 || left > 0.0)) {
        size_t worst = 0;
        for (size_t i = 1; i < self->inputs; i++) {
            worst = part[i] > part[worst] ? i : worst;
        }
        places[count++] = worst;
        left -= part[worst];
        part[worst] = -INFINITY;
    }
    return count;
}

double gaussian_axis_deviation(const struct gaussian *self, const double *weights)
{
    double total = 0.0;
    for (size_t target = 0; target < self->targets; target++) {
        total += fabs(weights[target]) * self->spread[target];
    }
    return total;
}
