/* Eigenvalues and eigenvectors of a symmetric matrix. */
#ifndef EIGEN_H
#define EIGEN_H

#include <stdbool.h>
#include <stddef.h>

/* Puts the eigenvalues into values and the orthonormal eigenvectors into the rows of vectors,
   which hold the matrix before; work has room for 2 size numbers. Returns whether it came to an
   end: a matrix that is not finite has none. */
bool symmetric_eigen(size_t size, double *vectors, double *values, double *work);

#endif
