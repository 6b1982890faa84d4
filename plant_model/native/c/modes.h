/* The modes of the thermal network at one set of conductances. */
#ifndef MODES_H
#define MODES_H

#include <stdbool.h>

#include "machine_data.h"

/* C dT/dt = -L T + B u + q at one level, the values of the inputs that conductances depend on.
   With y = C^(1/2) T the matrix is symmetric. */
struct conductances {
    double level[AT_LEAST_ONE(LEVELS)];
    double diagonal[NODES];               /* of C^(-1/2) L C^(-1/2) [1/s] */
    double edges[AT_LEAST_ONE(EDGES)];    /* beside the diagonal */
    double outside[AT_LEAST_ONE(OUTSIDE)]; /* B [W/K] */
    double fastest;                       /* no mode decays faster than this [1/s] */
    bool known;
};

struct modes {
    double level[AT_LEAST_ONE(LEVELS)];
    double decay[NODES];           /* [1/s] */
    double to_state[NODES][NODES]; /* row by row */
    double to_modes[NODES][NODES];
    double step_s, keep[NODES], gain[NODES]; /* of a step: T' = keep T + gain f / C */
    bool known, step_known;
};

/* phi_1, phi_2, phi_3 of x <= 0: see the Python twin, integrate.phi. */
double phi(int order, double x);

/* Computes the conductances at a level. */
void conductances_at(
    struct conductances *self, const double *k, const double *root, const double *u);

/* Puts down what A y is, A = C^(-1/2) L C^(-1/2). */
void conductances_times(const struct conductances *self, const double *y, double *out);

/* Finds the modes; returns whether there are any. */
bool modes_of(struct modes *self, const struct conductances *of, const double *root);

/* Puts down matrix times vector. */
void matrix_times(const double *matrix, const double *vector, double *out);

bool same_level(const double *one, const double *other);

#endif
