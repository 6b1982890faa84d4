/* Derivatives of the outputs by the inputs of the last step. */
#include <math.h>
#include <string.h>

#include "compensator.h"
#include "geometry.h"
#include "numbers.h"

/* Computes the derivative of the targets in the direction of temperatures in self->rises; returns
   that of their variance. A prediction is a constant plus a weighted sum: its own derivative. */
static double targets_moved(struct compensator *self)
{
    struct sample sample = {self->readings, 0.0, 0.0, NULL};
    memset(self->readings, 0, model_chosen_count * sizeof(double));
    compensator_mean(self, &sample, self->missed);
    sample.inputs = self->rises;
    compensator_mean(self, &sample, self->moved);
    for (size_t target = 0; target < model_target_count; target++) {
        self->moved[target] -= self->missed[target];
    }
    return gaussian_derive(&self->gaussian, self->learnt, self->rises, self->moved);
}

/* Returns the derivative of the root of a unit of variance along an axis by the tool length. */
static double spread_moved(const struct compensator *self, size_t axis, double tool_seed)
{
    if (!model_geometry.needs_tool_length || axis == 2) {
        return 0.0;
    }
    const double *noise = model_gaussian.noise + 1 + axis;
    double turned = 0.0;
    for (size_t column = 0; column < model_target_count; column++) {
        turned += compensator_noise(self, axis, column) * noise[column * model_target_count];
    }
    return tool_seed * GEOMETRY_UM_PER_MM * GEOMETRY_RAD_PER_URAD * turned / self->spread[axis];
}

void compensator_derive(
    struct compensator *self, double tool_length, const double *seeds, double tool_seed,
    double found[REAL_OUTPUTS])
{
    const struct content *now = self->now;
    double drift[3], moved[3], share = model_limits.share, variance = self->learnt->variance;
    memset(found, 0, REAL_OUTPUTS * sizeof *found);
    if (now->unmodelled > 0.0) {
        return; /* The sample was bad, so nothing depends on it. */
    }
    for (size_t place = 0; place < model_chosen_count; place++) {
        self->rises[place] = seeds[model_chosen[place]];
    }
    if (model_spare.precision != NULL) {
        spare_derive(&self->spare, self->spared, self->rises);
    }
    double more = targets_moved(self);
    geometry_drift(now->targets, tool_length, drift);
    geometry_derive(now->targets, tool_length, self->moved, tool_seed, moved);
    geometry_pose(self->moved, found + 3);
    for (size_t axis = 0; axis < 3; axis++) {
        double spread = self->spread[axis], wanted = now->wanted[axis];
        double sent = fabs(wanted) < model_limits.offset_um ? 0.0 - share * moved[axis] : 0.0;
        /* An offset held back by the slew limit does not depend on the inputs. */
        if (now->fault.cause == 0 && now->output.offset[axis] == wanted) {
            found[axis] = sent;
        }
        if (spread > 0.0) {
            double turned = spread_moved(self, axis, tool_seed);
            found[6 + axis] = model_gaussian.deviations * spread
                                  * (0.5 * more * spread + variance * turned)
                                  / sqrt(compensator_variance(self, axis))
                              + copysign(1.0, drift[axis] + wanted) * (moved[axis] + sent);
        }
    }
}
