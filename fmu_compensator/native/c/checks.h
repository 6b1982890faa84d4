/* Checks whether temperature readings can be used. */
#ifndef CHECKS_H
#define CHECKS_H

#include <stdint.h>

#include "model_data.h"

/* Why the inputs cannot be used, or what a status is about; its text is made on request.

   If conditions are new, the value is their share of the uncertainty [%]. */
struct reason {
    int32_t cause;  /* 1 to 4, see the status codes; 0: none */
    int32_t sensor; /* from 1; 0: none */
    double value;   /* the reading */
    double extent;  /* size of the jump [K], or time unchanged [s] */
    double allowed; /* largest allowed jump [K] */
};

/* Memory of one sensor; NaN: none. */
struct sensor_memory {
    double reference;    /* of its rises [degC] */
    double good;         /* the last good reading [degC] */
    double since_good;   /* [s] */
    double jumped_after; /* age of the last good one at the jump [s] */
    double last;         /* the last reading of any kind [degC] */
    double unchanged;    /* for how long it has been the same [s] */
    double moves;        /* how often it has changed, counted up to a limit */
};

/* Returns the fault of a reading elapsed_s after the previous one; cause 0: none.

   A reading is good within a corridor around the last good one. The corridor widens with time at
   the sensor's rate limit, but after a jump only for a while: a shifted sensor must come back. */
struct reason sensor_look(
    const struct sensor *sensor, struct sensor_memory *memory, double value, double elapsed_s);

#endif
