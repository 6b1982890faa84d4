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
    double edges[AT_LEAST_ONE(EDGES)];     /* beside it */
    double outside[AT_LEAST_ONE(OUTSIDE)]; /* B [W/K] */
    double fastest, sharper; /* no mode decays faster than either [1/s]; 0: not known */
    bool known;
    double scale, shifted[NODES], stretched[NODES]; /* see series.c; 0: not known */
};

/* Sees to it that the conductances are those at the inputs: what they do not move stays. */
void network_at(struct network *self, const double *k, const double *u);

/* Returns what no mode decays faster than [1/s]: sharper where the series of a step, as many as it
   takes, get enough shorter. */
double network_fastest(struct network *self, double step_s, int series);

#endif
