/* Stepping a network in which something depends on temperature: see the Python twins,
   side_by_side.py and integrate.py, for the scheme and its sources. */
#include <float.h>
#include <math.h>
#include <string.h>

#include "formulas.h"
#include "plant.h"

#define NO_STEP "error control cannot reach its tolerance: the model changes too fast"

enum { OF_HALF, OF_FULL, HALF_GAIN, GAIN, SLOPE_GAIN, BEND_GAIN };

/* Inputs of a step's forcing. */
struct step {
    struct plant *plant;
    const double *inputs, *force, *held;
};

/* The own decay of each own state is stepped exactly. */
static void weigh(struct plant *self, double h)
{
    if (self->weights_step_s == h) {
        return;
    }
    for (int i = 0; i < STATES; i++) {
        double x = -self->decay[i] * h, p2 = phi(2, x);
        self->weights[OF_HALF][i] = exp(x / 2.0);
        self->weights[OF_FULL][i] = exp(x);
        self->weights[HALF_GAIN][i] = phi(1, x / 2.0) * (h / 2.0);
        self->weights[GAIN][i] = h * phi(1, x);
        self->weights[SLOPE_GAIN][i] = 2.0 * h * p2;
        self->weights[BEND_GAIN][i] = h * (4.0 * phi(3, x) - p2);
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
        found.nodes[i] = (step->force[i] + heat[i]) * plant->network.share[i];
    }
    for (int i = 0; i < STATES; i++) {
        found.states[i] += plant->decay[i] * at->states[i];
    }
    return found;
}

/* One step of length h; returns the largest error [K].

   With the slope v1 at the start, the difference v2 of the forcing at the middle from that at the
   start, and the curvature of the forcing e = f_b - f_0 - 2 v2, the scheme is
   Ta = T + h/2 phi_1(h/2) v1, Tb = T + h phi_1 (v1 + 2 v2),
   T' = T + h (phi_1 v1 + 2 phi_2 v2 + (4 phi_3 - phi_2) e); the last term is the error. */
static double once(
    const struct step *step, double h, const struct point *state, struct point *end)
{
    static const int first[] = {HALF, ONE}, second[] = {ONE, TWO}, third[] = {BENT};
    struct plant *plant = step->plant;
    struct network *network = &plant->network;
    double(*w)[AT_LEAST_ONE(STATES)] = plant->weights;
    double p[2][ROW] = {{0.0}}, q[2][ROW] = {{0.0}}, r[ROW] = {0.0}, v[NODES], worst = 0.0;
    double *const ps[] = {p[0], p[1]}, *const qs[] = {q[0], q[1]}, *const rs[] = {r};
    const struct series *series = series_for(&plant->series, network->fastest * h);
    struct point f0 = forcing(step, state), at;
    weigh(plant, h);
    equations_product(
        network->diagonal, network->entries, network->share, state->nodes, f0.nodes, 0.0, v, r);
    /* v is -v1; the truncation error of series is small compared with it. */
    double slope = largest_of(v, NODES);
    series_add(series, network, h, v, 0.0, 2, first, ps);
    for (size_t i = 0; i < NODES; i++) {
        at.nodes[i] = state->nodes[i] - h * p[0][i];
    }
    for (int i = 0; i < STATES; i++) {
        at.states[i] = w[OF_HALF][i] * state->states[i] + w[HALF_GAIN][i] * f0.states[i];
    }
    struct point fa = forcing(step, &at);
    for (size_t i = 0; i < NODES; i++) {
        v[i] = fa.nodes[i] - f0.nodes[i];
    }
    series_add(series, network, h, v, slope, 2, second, qs);
    for (size_t i = 0; i < NODES; i++) {
        at.nodes[i] = state->nodes[i] - h * (p[1][i] - 2.0 * q[0][i]);
    }
    for (int i = 0; i < STATES; i++) {
        at.states[i] = w[OF_FULL][i] * state->states[i]
                       + w[GAIN][i] * (2.0 * fa.states[i] - f0.states[i]);
    }
    struct point fb = forcing(step, &at);
    for (size_t i = 0; i < NODES; i++) {
        v[i] = f0.nodes[i] - 2.0 * fa.nodes[i] + fb.nodes[i];
    }
    series_add(series, network, h, v, slope, 1, third, rs);
    for (size_t i = 0; i < NODES; i++) {
        end->nodes[i] = state->nodes[i] - h * (p[1][i] - 2.0 * q[1][i] - r[i]);
    }
    for (int i = 0; i < STATES; i++) {
        double bend = f0.states[i] - 2.0 * fa.states[i] + fb.states[i];
        double error = w[BEND_GAIN][i] * bend;
        end->states[i] = w[OF_FULL][i] * state->states[i] + w[GAIN][i] * f0.states[i]
                         + w[SLOPE_GAIN][i] * (fa.states[i] - f0.states[i]) + error;
        worst = larger(fabs(error / plant->scales[i]), worst);
    }
    for (size_t i = 0; i < NODES; i++) {
        r[i] /= machine_node_scales[i];
    }
    return larger(h * largest_of(r, NODES), worst);
}

/* Steps through an interval, in equal parts until the error requires others. */
static const char *interval(
    const struct step *step, double length, double *part, struct point *state)
{
    double at = 0.0, now = *part;
    double least = step->plant->network.fastest * length / MOST_REACH;
    double left = ceil(1.0 / now - ROUNDING);
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
        } else if (now <= DBL_EPSILON || parts > MOST_PARTS || !isfinite(excess)) {
            return NO_STEP;
        } else {
            left = ceil(smaller(left * sqrt(excess), (1.0 - at) / DBL_EPSILON));
        }
    }
    *part = smaller(1.0, now);
    return NULL;
}

const char *dependent_advance(
    struct plant *self, double step_s, const double *inputs, const double *held,
    const double *force, double *part, struct point *state)
{
    struct step step = {self, inputs, force, held};
    const char *problem = interval(&step, step_s, part, state);
    if (problem == NULL && machine_settles) {
        double settled[AT_LEAST_ONE(STATES)];
        equations_settled(self->k, inputs, state->nodes, state->states, settled);
        memcpy(state->states, settled, STATES * sizeof *settled);
    }
    return problem;
}
