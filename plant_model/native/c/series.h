/* The functions phi_k of a network's matrix, times a vector: Chebyshev series.

   A step of a linear network is T(t + h) = T + h phi_1(-h A) (f / C - A T), which is exact, and what
   depends on temperature adds phi_2 and phi_3 (Hochbruck and Ostermann, Acta Numerica 19 (2010)
   209-286, doi:10.1017/S0962492910000048). The eigenvalues of h A are real and lie between 0 and its
   reach, where the series of phi_k converges faster than any other polynomial's; it needs no more
   than the network times a vector. So a step costs the same whatever has changed since the last. */
#ifndef SERIES_H
#define SERIES_H

#include "network.h"

#define MOST_REACH 4096.0
#define SERIES_KEPT 8
#define TERMS_KEPT 512 /* above what the longest series takes while it is made, 347 */

enum { ONE, HALF, TWO, BENT, SERIES }; /* phi_1, phi_1(x / 2) / 2, phi_2, 4 phi_3 - phi_2 */

struct term {
    double weights[SERIES]; /* from the second term on half of what they are */
    double rest;            /* the largest weight from this term on, of any kind */
};

struct series {
    double reach, above; /* for what is above the latter, up to the former */
    size_t count; /* 0: not known */
    const struct term *terms;
};

/* What is kept follows from the reach alone. */
struct all_series {
    struct series kept[SERIES_KEPT];
    struct term terms[TERMS_KEPT];
    size_t next, end; /* to be overwritten: a series, and terms from here on */
};

/* phi_1, phi_2, phi_3 of x <= 0: see the Python twin, integrate.phi. */
double phi(int order, double x);

/* Returns the series for a reach, which is not above the most. */
const struct series *series_for(struct all_series *self, double reach);

/* Adds series of h A times a vector to sums, as many as there are kinds. What they leave off is
   small beside the vector's largest number, or beside another one if that is greater. */
void series_add(
    const struct series *self, struct network *network, double h, const double vector[NODES],
    double beside, size_t count, const int kinds[], double *const sums[]);

#endif
