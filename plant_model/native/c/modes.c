#include "modes.h"

#include <math.h>
#include <string.h>

#include "eigen.h"

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

bool same_level(const double *one, const double *other)
{
    for (int i = 0; i < LEVELS; i++) {
        if (one[i] != other[i]) {
            return false;
        }
    }
    return true;
}

void conductances_at(
    struct conductances *self, const double *k, const double *root, const double *u)
{
    double rows[NODES];
    for (int i = 0; i < LEVELS; i++) {
        self->level[i] = u[machine_levels[i]];
    }
    equations_conductances(k, u, self->diagonal, self->edges, self->outside);
    for (size_t i = 0; i < NODES; i++) {
        self->diagonal[i] /= root[i] * root[i];
        rows[i] = fabs(self->diagonal[i]);
    }
    for (int i = 0; i < EDGES; i++) {
        struct pair edge = machine_edges[i];
        self->edges[i] /= root[edge.node] * root[edge.other];
        rows[edge.node] += fabs(self->edges[i]);
        rows[edge.other] += fabs(self->edges[i]);
    }
    self->fastest = 0.0;
    for (size_t i = 0; i < NODES; i++) {
        self->fastest = rows[i] > self->fastest ? rows[i] : self->fastest;
    }
    self->known = true;
}

void conductances_times(const struct conductances *self, const double *y, double *out)
{
    for (size_t i = 0; i < NODES; i++) {
        out[i] = self->diagonal[i] * y[i];
    }
    for (int i = 0; i < EDGES; i++) {
        struct pair edge = machine_edges[i];
        out[edge.node] += self->edges[i] * y[edge.other];
        out[edge.other] += self->edges[i] * y[edge.node];
    }
}

bool modes_of(struct modes *self, const struct conductances *of, const double *root)
{
    double(*vectors)[NODES] = self->to_modes;
    double work[2 * NODES];
    self->known = self->step_known = false;
    memset(self->to_modes, 0, sizeof self->to_modes);
    for (size_t i = 0; i < NODES; i++) {
        vectors[i][i] = of->diagonal[i];
    }
    for (int i = 0; i < EDGES; i++) {
        struct pair edge = machine_edges[i];
        vectors[edge.node][edge.other] = vectors[edge.other][edge.node] = of->edges[i];
    }
    if (!symmetric_eigen(NODES, vectors[0], self->decay, work)) {
        return false;
    }
    for (size_t i = 0; i < NODES; i++) {
        /* Heat cannot run up a difference: a negative rate is rounding of an isolated network. */
        self->decay[i] = self->decay[i] > 0.0 ? self->decay[i] : 0.0;
        for (size_t j = 0; j < NODES; j++) {
            self->to_state[j][i] = vectors[i][j] / root[j];
            vectors[i][j] *= root[j];
        }
    }
    memcpy(self->level, of->level, sizeof self->level);
    self->known = true;
    return true;
}

void matrix_times(const double *matrix, const double *vector, double *out)
{
    for (size_t i = 0; i < NODES; i++) {
        double sum = 0.0;
        for (size_t j = 0; j < NODES; j++) {
            sum += matrix[i * NODES + j] * vector[j];
        }
        out[i] = sum;
    }
}
