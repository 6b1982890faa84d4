#include "eigen.h"

#include <float.h>
#include <math.h>

#define MOST_ROUNDS 50

/* To a tridiagonal matrix by reflections (Householder): values hold the diagonal then, work the
   numbers beside it from its second place on, vectors the product of the reflections. See Martin,
   Reinsch and Wilkinson, Numer. Math. 11 (1968) 181-195, doi:10.1007/BF02161841. */
static void to_tridiagonal(size_t n, double *a, double *values, double *work)
{
    double *sums = work + n;
    for (size_t i = n - 1; i > 0; i--) {
        double *row = a + i * n;
        double squares = 0.0, scale = 0.0;
        for (size_t k = 0; k < i; k++) {
            scale += fabs(row[k]);
        }
        if (i == 1 || scale == 0.0) {
            work[i] = row[i - 1];
            values[i] = 0.0;
            continue;
        }
        for (size_t k = 0; k < i; k++) {
            row[k] /= scale;
            squares += row[k] * row[k];
        }
        double last = row[i - 1], length = last >= 0.0 ? -sqrt(squares) : sqrt(squares);
        work[i] = scale * length;
        squares -= last * length;
        row[i - 1] = last - length;
        double along = 0.0;
        /* p = A u / H, of which only the lower half of A is there. */
        for (size_t j = 0; j < i; j++) {
            work[j] = 0.0;
        }
        for (size_t j = 0; j < i; j++) {
            const double *other = a + j * n;
            double sum = other[j] * row[j];
            for (size_t k = 0; k < j; k++) {
                sum += other[k] * row[k];
                work[k] += other[k] * row[j];
            }
            work[j] += sum;
        }
        for (size_t j = 0; j < i; j++) {
            work[j] /= squares;
            along += work[j] * row[j];
        }
        along /= 2.0 * squares;
        for (size_t j = 0; j < i; j++) {
            work[j] -= along * row[j];
        }
        for (size_t j = 0; j < i; j++) {
            double *other = a + j * n;
            for (size_t k = 0; k <= j; k++) {
                other[k] -= row[j] * work[k] + work[j] * row[k];
            }
        }
        for (size_t k = 0; k < i; k++) {
            a[k * n + i] = row[k] / squares; /* u / H, above the diagonal */
        }
        values[i] = squares;
    }
    values[0] = work[0] = 0.0;
    for (size_t i = 0; i < n; i++) {
        double *row = a + i * n;
        if (values[i] != 0.0) {
            /* (1 - u u' / H) on what is there so far, a row at a time. */
            for (size_t j = 0; j < i; j++) {
                sums[j] = 0.0;
            }
            for (size_t k = 0; k < i; k++) {
                for (size_t j = 0; j < i; j++) {
                    sums[j] += row[k] * a[k * n + j];
                }
            }
            for (size_t k = 0; k < i; k++) {
                double share = a[k * n + i];
                for (size_t j = 0; j < i; j++) {
                    a[k * n + j] -= sums[j] * share;
                }
            }
        }
        values[i] = row[i];
        row[i] = 1.0;
        for (size_t j = 0; j < i; j++) {
            row[j] = a[j * n + i] = 0.0;
        }
    }
}

static void transpose(size_t n, double *a)
{
    for (size_t i = 0; i < n; i++) {
        for (size_t j = 0; j < i; j++) {
            double kept = a[i * n + j];
            a[i * n + j] = a[j * n + i];
            a[j * n + i] = kept;
        }
    }
}

/* One sweep of the QL method with implicit shifts over the rows from first to last. See Dubrulle,
   Martin and Wilkinson, Numer. Math. 12 (1968) 377-383, doi:10.1007/BF02165404. */
static void sweep(size_t n, size_t first, size_t last, double *vectors, double *d, double *e)
{
    double g = (d[first + 1] - d[first]) / (2.0 * e[first]);
    double r = sqrt(g * g + 1.0), s = 1.0, c = 1.0, p = 0.0;
    g = d[last] - d[first] + e[first] / (g + (g >= 0.0 ? r : -r));
    for (size_t i = last; i-- > first;) {
        double f = s * e[i], b = c * e[i];
        r = sqrt(f * f + g * g);
        e[i + 1] = r;
        if (r == 0.0) {
            d[i + 1] -= p;
            e[last] = 0.0;
            return;
        }
        s = f / r;
        c = g / r;
        g = d[i + 1] - p;
        r = (d[i] - g) * s + 2.0 * c * b;
        p = s * r;
        d[i + 1] = g + p;
        g = c * r - b;
        double *one = vectors + i * n, *next = one + n;
        for (size_t k = 0; k < n; k++) {
            double kept = next[k];
            next[k] = s * one[k] + c * kept;
            one[k] = c * one[k] - s * kept;
        }
    }
    d[first] -= p;
    e[first] = g;
    e[last] = 0.0;
}

bool symmetric_eigen(size_t n, double *vectors, double *values, double *work)
{
    to_tridiagonal(n, vectors, values, work);
    transpose(n, vectors);
    for (size_t i = 1; i < n; i++) {
        work[i - 1] = work[i];
    }
    work[n - 1] = 0.0;
    for (size_t first = 0; first < n; first++) {
        for (int round = 0;; round++) {
            size_t last = first;
            while (last + 1 < n) {
                double beside = fabs(values[last]) + fabs(values[last + 1]);
                if (fabs(work[last]) <= DBL_EPSILON * beside) {
                    break;
                }
                last++;
            }
            if (last == first) {
                break;
            }
            if (round == MOST_ROUNDS) {
                return false;
            }
            sweep(n, first, last, vectors, values, work);
        }
    }
    return true;
}
