/* How far the present inputs are from all that was trained on, and what is still known there. */
#ifndef GUARD_H
#define GUARD_H

#include <stdbool.h>
#include <stddef.h>

#include "constants.h"
#include "fields.h"
#include "setup.h"

/* See the Python twin. It is constant once made; its owner keeps the state, in the order in which
   the Python twin's state() lists it. */
struct guard {
    size_t inputs, targets, lags, width, directions; /* width: features of a sample */
    size_t states;                                   /* how many numbers it remembers */
    bool fixed;                                      /* rises count from fixed temperatures */
    const double *lags_s, *usual, *constant, *seen, *leash;
    double prior, known;
    double fade_shortest[3], fade_longest[3];
    double *weights;                                   /* a row of features per target */
    double *features, *rises, *sorted, *shares, *part; /* of the last sample */
};

/* Makes the guard that a table of the file describes; NULL where the file has none. */
struct guard *guard_make(
    struct setup *setup, const struct field *table, size_t inputs, size_t targets);

/* Takes in one good sample; puts down what the careful model predicts [um, urad] and returns the
   novelty [1]. The readings are the chosen temperatures [degC]. */
double guard_step(
    const struct guard *guard, double *state, const double *readings, double elapsed_s,
    double *careful);

/* Returns what a sensor is likely to read at the start, from the median of what the others read
   [degC]; NaN where rises count from fixed temperatures. */
double guard_usual_start(const struct guard *guard, size_t place, double middle);

/* Puts an error model's prediction on its leash to the careful one [um, urad]. */
void guard_hold(const struct guard *guard, double *targets, const double *careful);

/* Returns which share of an axis's offset is still backed by what is known, 0 to 1. */
double guard_faded(
    const struct guard *guard, size_t axis, double novelty, double tool_share, double doubt);

/* Puts down the places of the inputs that make the last sample new, the worst first; returns how
   many they are, at least one. */
size_t guard_culprits(const struct guard *guard, double novelty, size_t places[GUARD_CULPRITS]);

#endif
