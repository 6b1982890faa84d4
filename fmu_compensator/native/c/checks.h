/* Is a temperature reading fit for use? */
#ifndef CHECKS_H
#define CHECKS_H

#include <stdint.h>

#include "model_data.h"

/* Why the inputs cannot be used, or what an output is about; its words are made when asked for.

   Where conditions are new, the value is their part of the uncertainty [%]. */
struct reason {
    int32_t cause;  /* 1 to 4, see the status codes; 0: none */
    int32_t sensor; /* from 1; 0: none */
    double value;   /* the reading */
    double extent;  /* how far it jumped [K], or for how long it is unchanged [s] */
    double allowed; /* of the jump [K] */
};

/* What is remembered of one sensor; NaN stands for nothing. */
struct sensor_memory {
    double reference;    /* from where its rises count [degC] */
    double good;         /* the last good reading [degC] */
    double since_good;   /* [s] */
    double jumped_after; /* how old the good one was at the jump [s] */
    double last;         /* the last reading of any kind [degC] */
    double unchanged;    /* for how long it has been the same [s] */
    double moves;        /* how often it has changed, as far as that is counted */
};

/* Returns what is wrong with a reading, taken elapsed_s after the one before; cause 0: nothing.

   A reading is good within a corridor around the last good one. The corridor widens with time at
   the sensor's rate limit, but after a jump only for a while: a shifted sensor must come back. */
struct reason sensor_look(
    const struct sensor *sensor, struct sensor_memory *memory, double value, double elapsed_s);

#endif
