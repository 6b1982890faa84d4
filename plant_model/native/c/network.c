#include "network.h"

#include "formulas.h"

#define SHARP_REACH 2.0 /* of one series: from here on a sharper bound saves what it costs */

void network_at(struct network *self, const double *k, const double *u)
{
    bool same = self->known;
    for (int i = 0; i < LEVELS; i++) {
        same = same && self->level[i] == u[machine_levels[i]];
        self->level[i] = u[machine_levels[i]];
    }
    if (same) {
        return;
    }
    if (self->known) {
        equations_moving(k, u, self->diagonal, self->edges, self->outside);
    } else {
        equations_conductances(k, u, self->diagonal, self->edges, self->outside);
    }
    self->known = true;
    double given[NODES];
    for (size_t i = 0; i < NODES; i++) {
        given[i] = self->diagonal[i] * self->share[i];
    }
    /* Gershgorin: what a node gives off in all, and what it gives to other nodes at most. */
    self->fastest = 2.0 * largest_of(given, NODES);
    self->sharper = self->scale = 0.0;
}

/* The matrix of the rates' magnitudes, M, has no eigenvalue above the greatest (M x)_i / x_i for any
   positive x (Collatz), here what each node gives off: M^2 1 beside M 1, where Gershgorin has M 1. */
static double sharper(const struct network *self)
{
    double given[NODES], rates[NODES] = {0.0}, most = 0.0;
    for (size_t i = 0; i < NODES; i++) {
        given[i] = self->diagonal[i] * self->share[i];
    }
    equations_product(self->diagonal, self->edges, self->share, given, rates);
    for (size_t i = 0; i < NODES; i++) {
        if (given[i] * (2.0 * given[i] - most) > rates[i]) {
            most = 2.0 * given[i] - rates[i] / given[i];
        }
    }
    return smaller(most, self->fastest);
}

double network_fastest(struct network *self, double step_s, int series)
{
    if (self->fastest * step_s * series < SHARP_REACH) {
        return self->fastest;
    }
    if (self->sharper == 0.0) {
        self->sharper = sharper(self);
    }
    return self->sharper;
}
