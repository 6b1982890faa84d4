/* What a measurement now and then says of the error: a bias that is believed less and less. */
#ifndef CORRECTION_H
#define CORRECTION_H

#include <stddef.h>

#include "fields.h"
#include "setup.h"

/* See the Python twin. It is constant once made; its owner keeps the state: the bias of each
   target, then their doubts, the errors that wait to be confirmed, and whether any does. */
struct correction {
    size_t targets;
    size_t states; /* how many numbers it remembers */
    double memory_s, fast;
    const double *spread, *noise;
};

/* Makes the correction that a table of the file describes; NULL where the file has none. */
struct correction *correction_make(
    struct setup *setup, const struct field *table, size_t targets);

/* Forgets all measurements. */
void correction_reset(const struct correction *correction, double *state);

/* Moves the bias towards a measurement of what was predicted, the bias in force included. */
void correction_take(
    const struct correction *correction, double *state, const double *measured,
    const double *predicted, double growth);

/* Lets time pass: the bias fades and the doubt grows. */
void correction_wait(const struct correction *correction, double *state, double elapsed_s);

/* Returns the share of the error's variance that is left since the last measurement, 0 to 1. */
double correction_doubt(const struct correction *correction, const double *state);

/* Returns what the last measurement said the targets were; zeros before the first. */
const double *correction_held(const struct correction *correction, const double *state);

#endif
