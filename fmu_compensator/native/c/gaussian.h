/* What the thermometers say of the drift, how surely, and what a measurement changes in it. */
#ifndef GAUSSIAN_H
#define GAUSSIAN_H

#include "model_data.h"
#include "setup.h"

/* Room for one sample; see the Python twin. */
struct gaussian {
    double *along, *column; /* of the last sample */
    double *direction;      /* of features */
    double *shares;         /* of the lags, then the elapsed time that they belong to */
};

struct gaussian_state {
    double hours, leaps, novelty, variance, left, suspected;
    double suspect[LANES], added[LANES];
    double features[]; /* rises, lag by lag, and 1; then weights and probes of each, in lanes */
};

void gaussian_make(struct setup *setup, struct gaussian *self);

/* Returns how many numbers are remembered. */
size_t gaussian_states(void);

/* Forgets everything but what was learnt. */
void gaussian_reset(struct gaussian_state *state);

/* Takes in one good sample; rises are those of the chosen sensors [K]. */
void gaussian_step(
    const struct gaussian *self, struct gaussian_state *state, const double *rises,
    double elapsed_s);

/* Conditions on a measurement at the last sample: what it is above the prediction [um, urad]. */
void gaussian_take(
    const struct gaussian *self, struct gaussian_state *state, const double *missed);

/* Adds how what is added to the targets moves with the rises of the last sample, in a direction of
   theirs [K]; returns how its variance does [1]. */
double gaussian_derive(
    const struct gaussian *self, struct gaussian_state *state, const double *rises, double *moved);

/* Variance of noise and walk over Sigma: what is left in conditions like training [1]. */
double gaussian_usual_variance(const struct gaussian_state *state);

/* Puts down the places of the inputs that make the last sample new, the worst first; returns how
   many they are, at least one. */
size_t gaussian_culprits(
    const struct gaussian *self, const struct gaussian_state *state,
    size_t places[GAUSSIAN_NAMED]);

#endif
