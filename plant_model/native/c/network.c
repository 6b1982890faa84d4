#include "network.h"

void network_at(struct network *self, const double *k, const double *share, const double *u)
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
    self->fastest = 0.0;
    for (size_t i = 0; i < NODES; i++) {
        /* Gershgorin: what a node gives off in all, and what it gives to other nodes at most. */
        double most = 2.0 * self->diagonal[i] * share[i];
        self->fastest = most > self->fastest ? most : self->fastest;
    }
}
