/* The Gaussian model: drift from temperatures, its variance, update by measurements. */
#ifndef GAUSSIAN_H
#define GAUSSIAN_H

#include "model_data.h"
#include "setup.h"

#define GAUSSIAN_USES_SPEED (model_gaussian.speed_rpm > 0.0)

/* Room for one sample; see the Python twin. */
struct gaussian {
    double *along, *column; /* of the last sample */
    double *direction;      /* of features */
    double *paces;          /* of each lag: its share, how far inputs are behind; then for which */
};

struct gaussian_state {
    double hours, speed; /* the speed since the last sample [rpm] */
    double leaps, novelty, variance, left, suspected;
    double suspect[LANES], added[LANES];
    double features[]; /* inputs, lag by lag, and 1; then weights and probes of each, in lanes */
};

void gaussian_make(struct setup *setup, struct gaussian *self);

/* Returns the length of the state. */
size_t gaussian_states(void);

/* Forgets everything except what was learnt in training. */
void gaussian_reset(struct gaussian_state *state);

/* Whether a speed can be used, or is not needed [rpm]. */
bool gaussian_knows(double speed);

/* Processes one good sample; inputs are the rises of the chosen sensors [K] with room for the speed
   and its square, the speed is that from now on [rpm]. */
void gaussian_step(
    const struct gaussian *self, struct gaussian_state *state, double *inputs, double elapsed_s,
    double speed);

/* Conditions on a measurement at the last sample, given minus the prediction [um, urad]. */
void gaussian_take(
    const struct gaussian *self, struct gaussian_state *state, const double *missed);

/* Adds the directional derivative of the Gaussian's contribution to the targets by the rises of the
   last sample, in a direction of rises [K]; returns that of its variance [1]. */
double gaussian_derive(
    const struct gaussian *self, struct gaussian_state *state, const double *rises, double *moved);

/* Variance of noise and walk over Sigma: that in conditions like training [1]. */
double gaussian_usual_variance(const struct gaussian_state *state);

/* Lists the places of the inputs that make the last sample new, the worst first; the speed comes
   after the sensors. Returns their number, at least one. */
size_t gaussian_culprits(
    const struct gaussian *self, const struct gaussian_state *state,
    size_t places[GAUSSIAN_NAMED]);

#endif
