/* How an axis comes to the offset that is wanted: the twin of axes.py, which says why. */
#ifndef AXES_H
#define AXES_H

#include <stdbool.h>
#include <stdint.h>

#define COUNT_UM 0.01 /* what one count moves an axis by */

struct axis_offset {
    double slew_um_s, in_force_um;
    int32_t counts; /* what to give */
    double before_um, absorbed_um, stands_at_mm;
    int32_t asked; /* so many looks more the control gets to take what it was given */
    double held_um;
    bool taken;
};

/* Goes on from an offset that the control holds already, and from the counts that it was given. */
void axis_begin(struct axis_offset *self, double slew_um_s, double request_um, int32_t counts);

/* takes: the control is on, homed, and in a mode in which it takes offsets. */
void axis_step(
    struct axis_offset *self, double wanted_um, bool takes, double request_um, double command_mm,
    double elapsed_s);

/* Whether the control holds no offset, and has absorbed none. */
bool axis_at_zero(const struct axis_offset *self);

#endif
