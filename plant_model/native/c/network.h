/* The thermal network at one set of conductances. */
#ifndef NETWORK_H
#define NETWORK_H

#include <stdbool.h>

#include "machine_data.h"

/* C dT/dt = -L T + B u + q at one level: values of the inputs that conductances depend on. */
struct network {
    double entries[AT_LEAST_ONE(ENTRIES)]; /* of L off its diagonal, in the order of a product */
    double diagonal[ROW];                  /* of L [W/K] */
    double share[ROW], capacity[ROW];      /* 1 / C and C [K/J, J/K] */
    double shifted[ROW], stretched[ROW]; /* see series.c */
    double rows[3][ROW];                 /* of a series */
    double scale;                        /* of stretched; 0: not known */
    double level[AT_LEAST_ONE(LEVELS)];
    double outside[AT_LEAST_ONE(OUTSIDE)]; /* B [W/K] */
    double still[NODES], bound; /* part of the diagonal without inputs; bound of its decay [1/s] */
    double fastest;             /* no mode decays faster [1/s] */
    bool known, shifts; /* shifts: whether shifted is for this diagonal and scale */
};

/* Enters the parts that do not depend on inputs. Capacities must be known. */
void network_prepare(struct network *self, const double *k);

/* Updates the conductances that depend on inputs. */
void network_at(struct network *self, const double *k, const double *u);

#endif
