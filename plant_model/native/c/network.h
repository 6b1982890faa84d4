/* The thermal network at one set of conductances. */
#ifndef NETWORK_H
#define NETWORK_H

#include <stdbool.h>

#include "machine_data.h"

/* C dT/dt = -L T + B u + q at one level, the values of the inputs that conductances depend on. */
struct network {
    double capacity[NODES], share[NODES]; /* C and 1 / C [J/K, K/J] */
    double level[AT_LEAST_ONE(LEVELS)];
    double diagonal[NODES];                /* of L [W/K] */
    double entries[AT_LEAST_ONE(ENTRIES)]; /* beside it, as a product reads them */
    double outside[AT_LEAST_ONE(OUTSIDE)]; /* B [W/K] */
    double still[NODES], bound; /* what inputs do not move of the diagonal; of its decay [1/s] */
    double fastest;             /* no mode decays faster [1/s] */
    bool known;
    double scale, shifted[NODES], stretched[NODES]; /* see series.c; 0: not known */
};

/* Enters what inputs do not move. Capacities must be there. */
void network_prepare(struct network *self, const double *k);

/* Sees to it that the conductances are those at the inputs: what they do not move stays. */
void network_at(struct network *self, const double *k, const double *u);

#endif
