/* What a broken thermometer is likely to read, given the others. */
#ifndef SPARE_H
#define SPARE_H

#include <stdbool.h>
#include <stddef.h>

#include "fields.h"
#include "setup.h"

/* See the Python twin. It is constant once made; its owner keeps the state. */
struct spare {
    size_t inputs, targets;
    size_t states; /* how many numbers it remembers */
    double memory_s;
    const double *precision, *growth, *sensitivity, *usual;
    const double *usual_start; /* NULL: rises count from fixed temperatures */
    double *before, *rises, *moved, *solved, *rows; /* of one sample */
    size_t *broken;
};

/* The parts of the state, in the order in which the Python twin's state() lists them. */
struct spare_state {
    double *started, *stopped, *clock, *turn;
    double *first, *last, *own, *seen, *gap, *good_for, *unread, *shift; /* of each sensor */
    double *extra, *lasting;                                             /* of X, Y, Z */
};

/* What has come in with one sample. */
struct spare_sample {
    double *readings;    /* of the chosen sensors; those of bad ones are replaced [degC] */
    const bool *bad;     /* which cannot be used */
    double *reference;   /* what each read first, NaN: nothing yet; guessed where that must be */
    bool stands;         /* whether the reading of the one in turn is the one before */
    double elapsed_s;    /* since the sample before */
    double recover_s;    /* how long a sensor must be good to be used again */
    const double *axes;  /* how the drift along X, Y, Z follows from the targets, row by row */
};

/* Makes the spare that a table of the file describes; NULL where the file has none. */
struct spare *spare_make(
    struct setup *setup, const struct field *table, size_t inputs, size_t targets);

struct spare_state spare_state(const struct spare *self, double *state);

/* Forgets everything. */
void spare_reset(const struct spare *self, double *state);

/* Makes a direction of all readings one of those that are used: broken sensors' follow the others. */
void spare_derive(const struct spare *self, double *state, double *readings);

/* Takes in one sample; returns whether it is possible to go on. */
bool spare_step(const struct spare *self, double *state, const struct spare_sample *sample);

#endif
