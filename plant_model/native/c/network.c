#include "network.h"

#include <string.h>

#include "formulas.h"

#define ROUNDS 4   /* the bound is then 1 % above the eigenvalue, on the shipped machines */
#define LEAST 1e-3 /* of the largest; any number above 0 gives a bound */

/* The matrix M of the rates' magnitudes has no eigenvalue above the greatest (M x)_i / x_i for any
   positive x (Collatz); the bound gets closer each time M is applied to x. */
static double bound(const struct network *self)
{
    static const double none[NODES];
    double x[NODES], rates[NODES], ratios[NODES] = {0.0}, most = 0.0;
    for (size_t i = 0; i < NODES; i++) {
        x[i] = 1.0;
    }
    for (int round = 0; round < ROUNDS; round++) {
        equations_product(
            self->diagonal, self->entries, self->share, x, none, 0.0, rates, ratios);
        for (size_t i = 0; i < NODES; i++) {
            rates[i] = 2.0 * self->diagonal[i] * self->share[i] * x[i] - rates[i];
            ratios[i] = rates[i] / x[i];
        }
        most = largest_of(ratios, NODES);
        double largest = largest_of(rates, NODES);
        for (size_t i = 0; i < NODES; i++) {
            x[i] = rates[i] > LEAST * largest ? rates[i] / largest : LEAST;
        }
    }
    return most;
}

void network_prepare(struct network *self, const double *k)
{
    equations_still(k, self->diagonal, self->entries, self->outside);
    memcpy(self->still, self->diagonal, sizeof self->still);
    self->bound = bound(self);
    self->known = false;
}

WIDE void network_at(struct network *self, const double *k, const double *u)
{
    bool same = self->known;
    for (int i = 0; i < LEVELS; i++) {
        same = same && self->level[i] == u[machine_levels[i]];
        self->level[i] = u[machine_levels[i]];
    }
    if (same) {
        return;
    }
    equations_moving(k, u, self->diagonal, self->entries, self->outside);
    double moving[ROW];
    for (size_t i = 0; i < NODES; i++) {
        moving[i] = (self->diagonal[i] - self->still[i]) * self->share[i];
    }
    /* The part that depends on inputs adds at most its own fastest mode: Gershgorin's bound. */
    self->fastest = self->bound + 2.0 * largest_of(moving, NODES);
    self->shifts = false;
    self->known = true;
}
