/* The thermal network at one set of conductances. */
#ifndef NETWORK_H
#define NETWORK_H

#include <stdbool.h>

#include "machine_data.h"

/* C dT/dt = -L T + B u + q at one level, the values of the inputs that conductances depend on. */
struct network {
    double entries[AT_LEAST_ONE(ENTRIES)]; /* of L beside its diagonal, as a product reads them */
    double diagonal[ROW];                  /* of L [W/K] */
    double share[ROW], capacity[ROW];      /* 1 / C and C [K/J, J/K] */
    double shifted[ROW], stretched[ROW]; /* see series.c */
    double rows[3][ROW];                 /* of a series */
    double scale;                        /* of the stretched; 0: not known */
    double level[AT_LEAST_ONE(LEVELS)];
    double outside[AT_LEAST_ONE(OUTSIDE)]; /* B [W/K] */
    double still[NODES], bound; /* what inputs do not move of the diagonal; of its decay [1/s] */
    double fastest;             /* no mode decays faster [1/s] */
    bool known, shifts; /* whether the shifted are for this diagonal and scale */
};

/* Enters what inputs do not move. Capacities must be there. */
void network_prepare(struct network *self, const double *k);

/* Sees to it that the conductances are those at the inputs: what they do not move stays. */
void network_at(struct network *self, const double *k, const double *u);

#endif
