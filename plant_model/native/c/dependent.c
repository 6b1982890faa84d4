/* Stepping a network in which something depends on temperature: see the Python twins, dependent.py
   and integrate.py, for the scheme and its sources. */
#include <math.h>
#include <string.h>

#include "formulas.h"
#include "plant.h"

#define TOLERANCE 1e-4               /* [K] */
#define SMALLEST_SPLIT 0x1p-15       /* of a step, or */
#define SMALLEST_S 5e-4              /* a length, whichever is less [s] */
#define ROUNDING 1e-6                /* less of a part is no part */
#define MOST_PARTS 100000            /* of a step, which is not to be endless */
#define NO_STEP "error control cannot reach its tolerance: the model changes too fast"

enum { OF_HALF, OF_FULL, A_GAIN, B_GAIN, W0, WA, WB };

/* Temperatures and own states, or what changes them [K/s]. */
struct point {
    double nodes[NODES], states[AT_LEAST_ONE(STATES)];
};

/* What a step's forcing is made of. */
struct step {
    struct plant *plant;
    const double *inputs, *force, *held;
    double fastest; /* no mode of the network decays faster [1/s] */
};

/* What own states lose by themselves is stepped exactly, each on its own. */
static void weigh(struct plant *self, double h)
{
    if (self->weights_step_s == h) {
        return;
    }
    for (int i = 0; i < STATES; i++) {
        double x = -self->decay[i] * h, p1 = phi(1, x), p2 = phi(2, x), p3 = phi(3, x);
        self->weights[OF_HALF][i] = exp(x / 2.0);
        self->weights[OF_FULL][i] = exp(x);
        self->weights[A_GAIN][i] = phi(1, x / 2.0) * (h / 2.0);
        self->weights[B_GAIN][i] = h * p1;
        self->weights[W0][i] = h * (p1 - 3.0 * p2 + 4.0 * p3);
        self->weights[WA][i] = h * (4.0 * p2 - 8.0 * p3);
        self->weights[WB][i] = h * (4.0 * p3 - p2);
    }
    self->weights_step_s = h;
}

static struct point forcing(const struct step *step, const struct point *at)
{
    const struct plant *plant = step->plant;
    struct point found;
    double heat[NODES];
    equations_dependent(
        plant->k, step->inputs, step->held, at->nodes, at->states, heat, found.states);
    for (size_t i = 0; i < NODES; i++) {
        found.nodes[i] = (step->force[i] + heat[i]) * plant->share[i];
    }
    for (int i = 0; i < STATES; i++) {
        found.states[i] += plant->decay[i] * at->states[i];
    }
    return found;
}

/* Puts series of a difference of forcings into sums; what is left off is small beside a slope, the
   difference's own where that is 0. Returns the slope. */
static double differ(
    const struct step *step, const struct series *series, double h, const double *one,
    const double *other, double slope, size_t count, const int kinds[], double sums[][NODES])
{
    const struct plant *plant = step->plant;
    double vector[NODES];
    for (size_t i = 0; i < NODES; i++) {
        vector[i] = one[i] - other[i];
    }
    return series_times(
        series, &plant->network, plant->share, h, vector, slope, count, kinds, sums);
}

/* One step of length h; returns the largest error, in K.

   With the differences of the forcings at the middle and the end from that at the start, v2 and v3,
   and v1, the slope at the start, the scheme is
   Ta = T + h/2 phi_1(h/2) v1, Tb = T + h phi_1 (v1 + 2 v2),
   T' = T + h (phi_1 v1 + phi_2 (4 v2 - v3) + 4 phi_3 (v3 - 2 v2)). */
static double once(
    const struct step *step, double h, const struct point *state, struct point *end)
{
    static const int first[] = {HALF, ONE}, second[] = {ONE, TWO, THREE}, third[] = {TWO, THREE};
    struct plant *plant = step->plant;
    double(*w)[AT_LEAST_ONE(STATES)] = plant->weights;
    double p[2][NODES], q[3][NODES], r[2][NODES], rates[NODES], worst = 0.0;
    const struct series *series = series_for(&plant->series, step->fastest * h);
    struct point f0 = forcing(step, state), at;
    weigh(plant, h);
    equations_rates(
        plant->network.diagonal, plant->network.edges, plant->share, state->nodes, rates);
    double slope = differ(step, series, h, f0.nodes, rates, 0.0, 2, first, p);
    for (size_t i = 0; i < NODES; i++) {
        at.nodes[i] = state->nodes[i] + h * p[0][i];
    }
    for (int i = 0; i < STATES; i++) {
        at.states[i] = w[OF_HALF][i] * state->states[i] + w[A_GAIN][i] * f0.states[i];
    }
    struct point fa = forcing(step, &at);
    differ(step, series, h, fa.nodes, f0.nodes, slope, 3, second, q);
    for (size_t i = 0; i < NODES; i++) {
        at.nodes[i] = state->nodes[i] + h * (p[1][i] + 2.0 * q[0][i]);
    }
    for (int i = 0; i < STATES; i++) {
        at.states[i] = w[OF_FULL][i] * state->states[i]
                       + w[B_GAIN][i] * (2.0 * fa.states[i] - f0.states[i]);
    }
    struct point fb = forcing(step, &at);
    differ(step, series, h, fb.nodes, f0.nodes, slope, 2, third, r);
    for (size_t i = 0; i < NODES; i++) {
        double bent = 4.0 * (r[1][i] - 2.0 * q[2][i]);
        end->nodes[i] = state->nodes[i] + h * (p[1][i] + 4.0 * q[1][i] - r[0][i] + bent);
        worst = larger(fabs(h * (bent - (r[0][i] - 2.0 * q[1][i]))), worst);
    }
    for (int i = 0; i < STATES; i++) {
        double a = fa.states[i], b = fb.states[i];
        double error = w[WB][i] * (f0.states[i] - 2.0 * a + b);
        end->states[i] = w[OF_FULL][i] * state->states[i] + w[W0][i] * f0.states[i]
                         + w[WA][i] * a + w[WB][i] * b;
        worst = larger(fabs(error / plant->scales[i]), worst);
    }
    return worst;
}

/* Goes through an interval, in equal parts as long as the error does not ask for others. */
static const char *interval(
    const struct step *step, double length, double *part, struct point *state)
{
    double at = 0.0, smallest = smaller(SMALLEST_SPLIT, SMALLEST_S / length), now = *part;
    double left = ceil(1.0 / now - ROUNDING), least = step->fastest * length / MOST_REACH;
    struct point end;
    for (long parts = 1; left > 0.0; parts++) {
        left = larger(left, ceil((1.0 - at) * least));
        now = (1.0 - at) / left;
        double excess = once(step, length * now, state, &end) / TOLERANCE;
        if (excess <= 1.0 && parts <= MOST_PARTS) {
            at += now;
            left -= 1.0;
            *state = end;
            if (excess <= 1.0 / 8.0) {
                now *= 2.0;
                left = ceil(left / 2.0);
            }
        } else if (now <= smallest || parts > MOST_PARTS || !isfinite(excess)) {
            return NO_STEP;
        } else {
            left = ceil(smaller(left * sqrt(excess), (1.0 - at) / smallest));
        }
    }
    *part = smaller(1.0, now);
    return NULL;
}

const char *dependent_advance(
    struct plant *self, double step_s, const double *inputs, const double *force, double *part,
    double *temperatures, double *states)
{
    struct point state;
    double held[AT_LEAST_ONE(KEPT_OF_INPUTS)];
    double fastest = network_fastest(&self->network, self->share, step_s, 3);
    struct step step = {self, inputs, force, held, fastest};
    equations_held(self->k, inputs, held);
    memcpy(state.nodes, temperatures, sizeof state.nodes);
    memcpy(state.states, states, STATES * sizeof *states);
    const char *problem = interval(&step, step_s, part, &state);
    if (problem != NULL) {
        return problem;
    }
    memcpy(temperatures, state.nodes, sizeof state.nodes);
    memcpy(states, state.states, STATES * sizeof *states);
    if (machine_settles) {
        double settled[AT_LEAST_ONE(STATES)];
        equations_settled(self->k, inputs, temperatures, states, settled);
        memcpy(states, settled, STATES * sizeof *states);
    }
    return NULL;
}
