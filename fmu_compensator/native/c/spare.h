/* What a broken thermometer is likely to read, given the others. */
#ifndef SPARE_H
#define SPARE_H

#include <stdbool.h>
#include <stddef.h>

#include "checks.h"
#include "setup.h"

/* Room for one sample; see the Python twin. */
struct spare {
    double *rises, *moved, *solved, *rows;
    size_t *broken, count; /* places of the sensors that are done without now */
};

/* In the names of the Python twin. */
struct spared {
    double first, last, own, seen, good_for, unread, shift;
};

struct spare_state {
    double started, clock, turn;
    double extra[3], lasting[3]; /* of X, Y, Z */
    struct spared sensors[];
};

/* What has come in with one sample. */
struct spare_sample {
    double *readings;              /* of the chosen sensors; bad ones' are replaced [degC] */
    const bool *bad;               /* which cannot be used */
    bool any_bad;
    struct sensor_memory *sensors; /* whose reference is guessed where that must be */
    double elapsed_s;              /* since the sample before */
    const double *axes; /* how the drift along X, Y, Z follows from the targets, row by row */
};

void spare_make(struct setup *setup, struct spare *self);

/* Returns how many numbers are remembered; 0 where the file has no spare. */
size_t spare_states(void);

/* Forgets everything. */
void spare_reset(struct spare_state *state);

/* Makes a direction of all readings one of those in use: broken sensors' follow the others'. */
void spare_derive(struct spare *self, const struct spare_state *state, double *readings);

/* Takes in one sample; returns whether it is possible to go on. */
bool spare_step(
    struct spare *self, struct spare_state *state, const struct spare_sample *sample);

#endif
