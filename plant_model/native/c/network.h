/* The thermal network at one set of conductances. */
#ifndef NETWORK_H
#define NETWORK_H

#include <stdbool.h>

#include "machine_data.h"

/* C dT/dt = -L T + B u + q at one level, the values of the inputs that conductances depend on. */
struct network {
    double level[AT_LEAST_ONE(LEVELS)];
    double diagonal[NODES];                /* of L [W/K] */
    double edges[AT_LEAST_ONE(EDGES)];     /* beside it */
    double outside[AT_LEAST_ONE(OUTSIDE)]; /* B [W/K] */
    double fastest;                        /* no mode decays faster than this [1/s] */
    bool known;
};

/* Sees to it that the conductances are those at the inputs: what they do not move stays. */
void network_at(struct network *self, const double *k, const double *share, const double *u);

#endif
