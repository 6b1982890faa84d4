/* Estimates the reading of a broken thermometer from the others. */
#ifndef SPARE_H
#define SPARE_H

#include <stdbool.h>
#include <stddef.h>

#include "checks.h"
#include "setup.h"

/* Room for one sample; see the Python twin. */
struct spare {
    double *rises, *moved, *solved, *rows;
    size_t *broken, count; /* places of the sensors that are replaced now */
};

/* Names as in the Python twin. */
struct spared {
    double first, last, own, seen, good_for, unread, shift;
};

struct spare_state {
    double started, clock, turn;
    double extra[3], lasting[3]; /* of X, Y, Z */
    struct spared sensors[];
};

/* One sample. */
struct spare_sample {
    double *readings;              /* of the chosen sensors; bad ones are replaced [degC] */
    const bool *bad;               /* sensors that cannot be used */
    bool any_bad;
    struct sensor_memory *sensors; /* missing references are estimated */
    double elapsed_s;              /* since the previous sample */
    const double *axes; /* derivatives of the drift along X, Y, Z by the targets, row by row */
};

void spare_make(struct setup *setup, struct spare *self);

/* Returns the length of the state; 0 if the file has no spare. */
size_t spare_states(void);

/* Forgets everything. */
void spare_reset(struct spare_state *state);

/* Converts a direction of readings to one of the readings in use: broken sensors follow others. */
void spare_derive(struct spare *self, const struct spare_state *state, double *readings);

/* Processes one sample; returns whether the compensator can continue. */
bool spare_step(
    struct spare *self, struct spare_state *state, const struct spare_sample *sample);

#endif
