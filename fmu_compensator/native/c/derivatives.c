/* How the outputs follow from the inputs of the last step. */
#include <math.h>
#include <string.h>

#include "compensator.h"
#include "numbers.h"

/* Puts down how the targets move with the directions of temperatures in self->rises; returns how
   their variance does. A prediction is a constant and a weighted sum, so it is its own derivative. */
static double targets_moved(const struct compensator *self, const struct parts *parts)
{
    const struct error_model *model = self->error_model;
    struct sample sample = {self->readings, 0.0, 0.0, NULL};
    memset(self->readings, 0, model_chosen_count * sizeof(double));
    model->kind->predict(model, parts->error_model, &sample, self->missed);
    sample.inputs = self->rises;
    model->kind->predict(model, parts->error_model, &sample, self->moved);
    for (size_t target = 0; target < model_target_count; target++) {
        self->moved[target] -= self->missed[target];
    }
    return gaussian_derive(&self->gaussian, parts->gaussian, self->rises, self->moved);
}

void compensator_derive(
    const struct compensator *self, const struct remembered *memory, double *numbers,
    double tool_length, const double *seeds, double tool_seed, double found[REAL_OUTPUTS])
{
    const struct gaussian *gaussian = &self->gaussian;
    struct parts parts = compensator_parts(self, numbers);
    double drift[3], moved[3];
    double turn = tool_seed * GEOMETRY_UM_PER_MM * GEOMETRY_RAD_PER_URAD;
    double variance = *gaussian_state(gaussian, parts.gaussian).variance;
    memset(found, 0, REAL_OUTPUTS * sizeof *found);
    if (memory->unmodelled > 0.0) {
        return; /* The sample was bad, so nothing follows it. */
    }
    for (size_t place = 0; place < model_chosen_count; place++) {
        self->rises[place] = seeds[model_chosen[place]];
    }
    if (self->spare != NULL) {
        spare_derive(self->spare, parts.spare, self->rises);
    }
    double more = targets_moved(self, &parts);
    geometry_drift(&self->geometry, parts.targets, tool_length, drift);
    geometry_derive(
        &self->geometry, parts.targets, tool_length, self->moved, tool_seed, moved);
    geometry_pose(&self->geometry, self->moved, found + 3);
    for (size_t axis = 0; axis < 3; axis++) {
        double spread = self->spread[axis], wanted = memory->wanted[axis];
        bool free = memory->fault.cause == 0 && fabs(wanted) < model_limits.offset_um;
        /* An offset that the slew limit holds back does not follow. */
        if (free && memory->offset[axis] == wanted) {
            found[axis] = 0.0 - model_limits.share * moved[axis];
        }
        if (spread > 0.0) {
            double size = variance * spread * spread, turned = 0.0;
            if (self->geometry.needs_tool_length && axis < 2) {
                double weight = self->axes[axis * model_target_count + 1 + axis];
                turned = (weight < 0.0 ? -turn : turn) * gaussian->spread[1 + axis];
            }
            if (self->spare != NULL) {
                size += spare_state(self->spare, parts.spare).extra[axis];
            }
            found[6 + axis] = gaussian->deviations * spread
                                  * (0.5 * more * spread + variance * turned) / sqrt(size)
                              + (1.0 - model_limits.share) * copysign(1.0, drift[axis]) * moved[axis];
        }
    }
}
