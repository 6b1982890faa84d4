#include "series.h"

#include <math.h>
#include <string.h>

#define SMALL 1e-12 /* a term that a series leaves off; phi_k is at most 1 */
#define PI 3.14159265358979323846

double phi(int order, double x)
{
    static const double factorials[] = {
        1.0, 1.0, 2.0, 6.0, 24.0, 120.0, 720.0, 5040.0, 40320.0, 362880.0, 3628800.0, 39916800.0,
        479001600.0, 6227020800.0, 87178291200.0, 1307674368000.0, 20922789888000.0,
        355687428096000.0, 6402373705728000.0};
    double value = 0.0, factorial = 1.0;
    if (fabs(x) < 0.5) {
        for (int j = 15; j >= 0; j--) {
            value = value * x + 1.0 / factorials[j + order];
        }
        return value;
    }
    value = expm1(x) / x;
    for (int k = 2; k <= order; k++) {
        factorial *= k - 1;
        value = (value - 1.0 / factorial) / x;
    }
    return value;
}

/* Finds the weights by the values at the zeros of a Chebyshev polynomial of more than enough terms,
   and leaves off what is small. */
static void make(struct series *self, int kinds, double reach)
{
    size_t count = 12 + (size_t)(7.4 * sqrt(reach / 2.0)), needed = 1;
    for (int kind = 0; kind < kinds; kind++) {
        memset(self->weights[kind], 0, count * sizeof(double));
    }
    for (size_t j = 0; j < count; j++) {
        double x = cos(PI * ((double)j + 0.5) / (double)count), z = -reach * (1.0 + x) / 2.0;
        double weight = 1.0 / (double)count, values[SERIES] = {phi(1, z)};
        if (kinds > 1) {
            values[HALF] = phi(1, z / 2.0) / 2.0;
            values[TWO] = z > -0.5 ? phi(2, z) : (values[ONE] - 1.0) / z;
            values[THREE] = z > -0.5 ? phi(3, z) : (values[TWO] - 0.5) / z;
        }
        double last = x, now = 1.0;
        for (size_t k = 0; k < count; k++) {
            for (int kind = 0; kind < kinds; kind++) {
                self->weights[kind][k] += values[kind] * weight * now;
            }
            weight = 2.0 / (double)count;
            double next = 2.0 * x * now - last;
            last = now;
            now = next;
        }
    }
    for (size_t k = 1; k < count; k++) {
        for (int kind = 0; kind < kinds; kind++) {
            needed = fabs(self->weights[kind][k]) > SMALL ? k + 1 : needed;
        }
    }
    self->terms = needed;
    self->reach = reach;
}

const struct series *series_for(struct all_series *self, double reach)
{
    /* In steps of an eighth at most: conductances that move a little share a series. */
    int exponent;
    double part = frexp(fmin(reach > 1e-9 ? reach : 1e-9, MOST_REACH), &exponent);
    double wide = ldexp(ceil(part * 16.0) / 16.0, exponent);
    for (size_t i = 0; i < SERIES_KEPT; i++) {
        if (self->kept[i].terms > 0 && self->kept[i].reach == wide) {
            return &self->kept[i];
        }
    }
    struct series *found = &self->kept[self->next];
    self->next = (self->next + 1) % SERIES_KEPT;
    make(found, self->kinds, wide);
    return found;
}

void series_times(
    const struct series *self, const struct network *network, const double *share, double h,
    const double vector[NODES], size_t count, const int kinds[], double sums[][NODES])
{
    double rows[2][NODES], rates[NODES], scale = 2.0 * h / self->reach;
    double *last = rows[0], *now = rows[1];
    equations_rates(network->diagonal, network->edges, share, vector, rates);
    for (size_t i = 0; i < NODES; i++) {
        last[i] = vector[i];
        now[i] = scale * rates[i] - vector[i];
    }
    for (size_t j = 0; j < count; j++) {
        const double *weights = self->weights[kinds[j]];
        for (size_t i = 0; i < NODES; i++) {
            sums[j][i] = weights[0] * last[i] + weights[1] * now[i];
        }
    }
    for (size_t k = 2; k < self->terms; k++) {
        double *next = last;
        equations_rates(network->diagonal, network->edges, share, now, rates);
        for (size_t i = 0; i < NODES; i++) {
            next[i] = 2.0 * (scale * rates[i] - now[i]) - last[i];
        }
        last = now;
        now = next;
        for (size_t j = 0; j < count; j++) {
            double weight = self->weights[kinds[j]][k];
            for (size_t i = 0; i < NODES; i++) {
                sums[j][i] += weight * now[i];
            }
        }
    }
}
