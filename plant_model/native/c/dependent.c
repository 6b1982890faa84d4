/* Stepping a network in which something depends on temperature: see the Python twins, dependent.py
   and integrate.py, for the scheme and its sources. */
#include <math.h>
#include <string.h>

#include "formulas.h"
#include "plant.h"

#define TOLERANCE 1e-4               /* [K] */
#define SMALLEST_SPLIT 0x1p-14
#define NO_STEP "error control cannot reach its tolerance: the model changes too fast"
#define NO_MODES "the thermal network is not finite"

enum { HALF, FULL, A_GAIN, B_GAIN, W0, WA, WB };

/* What a step's forcing is made of. */
struct step {
    const struct plant *plant;
    const struct modes *modes;
    const double *inputs, *force, *h;
    double (*weights)[SIZE];
};

static void weigh(struct plant *self, const struct modes *modes, double h)
{
    if (self->weights_of == modes && self->weights_step_s == h) {
        return;
    }
    for (size_t i = 0; i < SIZE; i++) {
        double decay = i < NODES ? modes->decay[i] : self->decay[i - NODES];
        double x = -decay * h, p1 = phi(1, x), p2 = phi(2, x), p3 = phi(3, x);
        self->weights[HALF][i] = exp(x / 2.0);
        self->weights[FULL][i] = exp(x);
        self->weights[A_GAIN][i] = phi(1, x / 2.0) * (h / 2.0);
        self->weights[B_GAIN][i] = h * p1;
        self->weights[W0][i] = h * (p1 - 3.0 * p2 + 4.0 * p3);
        self->weights[WA][i] = h * (4.0 * p2 - 8.0 * p3);
        self->weights[WB][i] = h * (4.0 * p3 - p2);
    }
    self->weights_of = modes;
    self->weights_step_s = h;
}

static void forcing(const struct step *step, const double *in_modes, double *out)
{
    const struct plant *plant = step->plant;
    const double *states = in_modes + NODES;
    double temperatures[NODES], heat[NODES], rate[NODES];
    matrix_times(step->modes->to_state[0], in_modes, temperatures);
    equations_dependent(
        plant->k, step->inputs, step->h, temperatures, states, heat, out + NODES);
    for (size_t i = 0; i < NODES; i++) {
        rate[i] = (step->force[i] + heat[i]) / plant->capacity[i];
    }
    matrix_times(step->modes->to_modes[0], rate, out);
    for (int i = 0; i < STATES; i++) {
        out[NODES + i] += plant->decay[i] * states[i];
    }
}

/* One step; returns the largest error, in K. */
static double once(
    const struct step *step, const double state[SIZE], double end[SIZE])
{
    double(*w)[SIZE] = step->weights;
    double f0[SIZE], fa[SIZE], fb[SIZE], at[SIZE], error[SIZE], in_kelvin[NODES], worst = 0.0;
    forcing(step, state, f0);
    for (size_t i = 0; i < SIZE; i++) {
        at[i] = w[HALF][i] * state[i] + w[A_GAIN][i] * f0[i];
    }
    forcing(step, at, fa);
    for (size_t i = 0; i < SIZE; i++) {
        at[i] = w[FULL][i] * state[i] + w[B_GAIN][i] * (2.0 * fa[i] - f0[i]);
    }
    forcing(step, at, fb);
    for (size_t i = 0; i < SIZE; i++) {
        end[i] = w[FULL][i] * state[i] + w[W0][i] * f0[i] + w[WA][i] * fa[i] + w[WB][i] * fb[i];
        error[i] = w[WB][i] * (f0[i] - 2.0 * fa[i] + fb[i]);
    }
    matrix_times(step->modes->to_state[0], error, in_kelvin);
    for (size_t i = 0; i < NODES; i++) {
        worst = larger(fabs(in_kelvin[i]), worst);
    }
    for (int i = 0; i < STATES; i++) {
        worst = larger(fabs(error[NODES + i] / step->plant->scales[i]), worst);
    }
    return worst;
}

/* Goes through an interval, splitting it where the error asks for it. */
static const char *interval(
    struct plant *self, const struct step *step, double length, double *part, double state[SIZE])
{
    double at = 0.0, end[SIZE];
    while (at < 1.0) {
        double now = smaller(*part, 1.0 - at);
        weigh(self, step->modes, length * now);
        double worst = once(step, state, end);
        if (worst <= TOLERANCE) {
            at += now;
            memcpy(state, end, sizeof end);
            if (worst < TOLERANCE / 16.0) {
                *part = smaller(1.0, 2.0 * *part);
            }
        } else if (*part <= SMALLEST_SPLIT || !isfinite(worst)) {
            return NO_STEP;
        } else {
            *part = now / 2.0;
        }
    }
    return NULL;
}

const char *dependent_advance(
    struct plant *self, double step_s, const double *inputs, const double *force, double *part,
    double *temperatures, double *states)
{
    double state[SIZE], h[AT_LEAST_ONE(KEPT_OF_INPUTS)];
    const struct modes *modes = plant_modes(self);
    if (modes == NULL) {
        return NO_MODES;
    }
    struct step step = {self, modes, inputs, force, h, self->weights};
    equations_held(self->k, inputs, h);
    matrix_times(modes->to_modes[0], temperatures, state);
    memcpy(state + NODES, states, STATES * sizeof *states);
    const char *problem = interval(self, &step, step_s, part, state);
    if (problem != NULL) {
        return problem;
    }
    matrix_times(modes->to_state[0], state, temperatures);
    memcpy(states, state + NODES, STATES * sizeof *states);
    if (machine_settles) {
        double settled[AT_LEAST_ONE(STATES)];
        equations_settled(self->k, inputs, temperatures, states, settled);
        memcpy(states, settled, STATES * sizeof *states);
    }
    return NULL;
}
