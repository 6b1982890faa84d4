/* What the thermometers say of the drift, how surely, and what a measurement changes in it. */
#ifndef GAUSSIAN_H
#define GAUSSIAN_H

#include <stdbool.h>
#include <stddef.h>

#include "constants.h"
#include "fields.h"
#include "setup.h"

/* So many sums are made side by side; a table in lanes has a row of them for each feature. */
#define LANES GAUSSIAN_MOST_PROBES

/* See the Python twin. It is constant once made; its owner keeps the state. */
struct gaussian {
    size_t inputs, targets, lags, width, directions; /* width: features of a sample */
    size_t states;                                   /* how many numbers it remembers */
    bool fixed;                                      /* rises count from fixed temperatures */
    double settled_h, scale, walk_per_h, deviations;
    const double *usual, *constant, *spread, *lags_s, *weights, *seen;
    double *lanes;          /* seen, in lanes: a table for each LANES of its rows */
    double *along, *column; /* of the last sample */
    double *direction;      /* of features */
    double *shares;         /* of the lags, then the elapsed time that they belong to */
};

/* The parts of the state: rises and lagged rises, then what else the Python twin's state() lists.
   Weights and probes are in lanes. */
struct gaussian_state {
    double *hours, *leaps, *novelty, *variance, *left, *suspected;
    double *features, *bias, *added, *suspect, *weights, *probes;
};

/* Makes the model that a table of the file describes. */
void gaussian_make(
    struct setup *setup, const struct field *table, size_t inputs, size_t targets,
    struct gaussian *self);

struct gaussian_state gaussian_state(const struct gaussian *self, double *state);

/* Forgets everything but what was learnt. */
void gaussian_reset(const struct gaussian *self, double *state);

/* Takes in one good sample; rises are those of the chosen sensors [K]. */
void gaussian_step(
    const struct gaussian *self, double *state, const double *rises, double elapsed_s);

/* Conditions on a measurement at the last sample: what it is above the prediction [um, urad]. */
void gaussian_take(const struct gaussian *self, double *state, const double *missed);

/* Adds how what is added to the targets moves with the rises of the last sample, in a direction of
   theirs [K]; returns how its variance does [1]. */
double gaussian_derive(
    const struct gaussian *self, double *state, const double *rises, double *moved);

/* Variance of noise and walk over Sigma: what is left in conditions like training [1]. */
double gaussian_usual_variance(const struct gaussian *self, double *state);

/* Puts down the places of the inputs that make the last sample new, the worst first; returns how
   many they are, at least one. */
size_t gaussian_culprits(
    const struct gaussian *self, double *state, size_t places[GAUSSIAN_NAMED]);

/* Returns the root of what a unit of variance is along an axis [um]. */
double gaussian_axis_deviation(const struct gaussian *self, const double *weights);

#endif
