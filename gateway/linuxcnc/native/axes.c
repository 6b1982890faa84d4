#include "axes.h"

#include <math.h>

#define PATIENCE 10    /* steps in which the control must take what it was given */

void axis_begin(struct axis_offset *self, double slew_um_s, double request_um, int32_t counts)
{
    *self = (struct axis_offset){
        slew_um_s, request_um, counts, request_um, 0.0, 0.0, 0, request_um, true};
}

void axis_step(
    struct axis_offset *self, double wanted_um, bool takes, double request_um, double command_mm,
    double elapsed_s)
{
    if (!takes) {
        if (self->taken) {
            self->taken = false;
            self->before_um = request_um;
        }
        self->asked = 0;
        return;
    }
    if (!self->taken) {
        self->absorbed_um += self->before_um - request_um;
        self->stands_at_mm = command_mm;
        self->taken = true;
    } else if (fabs(command_mm - self->stands_at_mm) > COUNT_UM / 1e3) {
        self->absorbed_um = 0.0;
    }
    self->in_force_um = request_um + self->absorbed_um;
    if (self->asked > 0 && request_um == self->held_um) {
        self->asked--;
        return;
    }
    double most = self->slew_um_s * elapsed_s;
    double change = fmin(fmax(wanted_um - self->in_force_um, -most), most);
    int32_t count = (int32_t)nearbyint(change / COUNT_UM);
    self->counts += count;
    self->asked = count != 0 ? PATIENCE : 0;
    self->held_um = request_um;
}

bool axis_at_zero(const struct axis_offset *self)
{
    double held = self->in_force_um - self->absorbed_um;
    return fmax(fabs(held), fabs(self->absorbed_um)) < COUNT_UM;
}
