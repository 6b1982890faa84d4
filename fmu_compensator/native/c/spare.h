/* What a broken thermometer is likely to read, given the others. */
#ifndef SPARE_H
#define SPARE_H

#include <stdbool.h>
#include <stddef.h>

#include "constants.h"
#include "fields.h"
#include "setup.h"

/* See the Python twin. It is constant once made; its owner keeps the state, in the order in which
   the Python twin's state() lists it. */
struct spare {
    size_t inputs;
    size_t states; /* how many numbers it remembers */
    double memory_s, deviations;
    const double *precision, *growth;
    const double *um_per_k[2], *usual_um[2]; /* at the shortest and the longest tool */
    double *before, *rises;                  /* of one sample */
};

/* The broken sensors; more than count can be gone on without, only the first ones stand here. */
struct broken {
    size_t count;
    size_t places[SPARE_MOST_BROKEN];
};

/* Makes the spare that a table of the file describes; NULL where the file has none. */
struct spare *spare_make(struct setup *setup, const struct field *table, size_t inputs);

/* Forgets everything. */
void spare_reset(const struct spare *spare, double *state);

/* Returns whose reading is compared with the others' in the next sample. */
size_t spare_turn(const double *state);

/* Returns the sensors that are done without, or wait for their return. */
struct broken spare_broken(const struct spare *spare, const double *state);

/* From where rises count if not all sensors are good at the start. */
struct starts {
    bool known;          /* false: all must be good */
    const double *first; /* what each sensor read first, or is likely to have read [degC] */
    const bool *unread;  /* of which it is only likely */
};

/* Takes in one sample and replaces what broken sensors read [degC]; bad tells of each whether its
   reading cannot be used. Returns whether it is possible to go on; if not, nothing is replaced. */
bool spare_step(
    const struct spare *spare, double *state, double *readings, const bool *bad, double idle,
    double elapsed_s, double recover_s, double tool_share, const struct starts *starts);

/* Returns which share of an axis's offset is still backed by what is known, 0 to 1. */
double spare_faded(
    const struct spare *spare, const double *state, size_t axis, double tool_share,
    double doubt);

/* Adds to half widths what the broken sensors bring [um]; what is not known stays so. */
void spare_widen(
    const struct spare *spare, const double *state, double half_width[3], double doubt);

#endif
