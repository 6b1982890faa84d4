/* Brings an axis to the wanted offset: the twin of axes.py, which gives the reasons. */
#ifndef AXES_H
#define AXES_H

#include <stdbool.h>
#include <stdint.h>

#define COUNT_UM 0.01 /* how far one count moves an axis */

struct axis_offset {
    double slew_um_s, in_force_um;
    int32_t counts; /* to give to the control */
    double before_um, absorbed_um, stands_at_mm;
    int32_t asked; /* remaining steps in which the control must take what it was given */
    double held_um;
    bool taken;
};

/* Continues from an offset that the control already holds and the counts that it was given. */
void axis_begin(struct axis_offset *self, double slew_um_s, double request_um, int32_t counts);

/* takes: the control is on, homed and in a mode that takes offsets. */
void axis_step(
    struct axis_offset *self, double wanted_um, bool takes, double request_um, double command_mm,
    double elapsed_s);

/* Returns whether the control holds no offset and has absorbed none. */
bool axis_at_zero(const struct axis_offset *self);

#endif
