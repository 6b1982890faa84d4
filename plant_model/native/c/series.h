/* Functions phi_k of a network's matrix, times a vector, by Chebyshev series.

   A step of a linear network is T(t + h) = T + h phi_1(-h A) (f / C - A T), which is exact; terms
   that depend on temperature add phi_2 and phi_3 (Hochbruck and Ostermann, Acta Numerica 19 (2010)
   209-286, doi:10.1017/S0962492910000048). The eigenvalues of h A are real and between 0 and its
   reach, where the Chebyshev series of phi_k converges faster than those of other polynomials; it
   needs only products of the network and a vector. So a step costs the same whatever has changed
   since the last. */
#ifndef SERIES_H
#define SERIES_H

#include "network.h"

#define MOST_REACH 4096.0
#define SERIES_KEPT 8
#define TERMS_KEPT 512 /* more than the longest series needs while it is made, 347 */

enum { ONE, HALF, TWO, BENT, SERIES }; /* phi_1, phi_1(x / 2) / 2, phi_2, 4 phi_3 - phi_2 */

struct term {
    double weights[SERIES]; /* from the second term on, half of the weight */
    double rest;            /* the largest weight from this term on, of any kind */
};

struct series {
    double reach, above; /* valid for a reach greater than above, up to reach */
    size_t count; /* 0: empty */
    const struct term *terms;
};

/* A cache; its content depends only on the reach. */
struct all_series {
    struct series kept[SERIES_KEPT];
    struct term terms[TERMS_KEPT];
    size_t next, end; /* to be overwritten next: a series, and the terms from here on */
};

/* phi_1, phi_2, phi_3 of x <= 0: see the Python twin, integrate.phi. */
double phi(int order, double x);

/* Returns the series for a reach up to MOST_REACH. */
const struct series *series_for(struct all_series *self, double reach);

/* Adds series of h A times a vector to sums, one sum for each kind. The truncation error is small
   compared with the vector's largest number, or with beside if that is greater. */
void series_add(
    const struct series *self, struct network *network, double h, const double vector[NODES],
    double beside, size_t count, const int kinds[], double *const sums[]);

#endif
