/* From predicted quantities to the drift of the tool tip. */
#ifndef GEOMETRY_H
#define GEOMETRY_H

#include <stdbool.h>
#include <stddef.h>

#include "fields.h"
#include "setup.h"

struct geometry {
    bool needs_tool_length; /* a rig with two radial sensors a direction; else a column an axis */
    bool pure_rotation;     /* the spindle turns about the gauge line and has no drift there */
    double near_to_gauge_mm;
    size_t columns;
    size_t axis[3]; /* of each column */
    double sign[3];
};

void geometry_make(struct setup *setup, const struct field *table, struct geometry *geometry);

/* Puts down the tool tip's drift along +X, +Y and +Z [um]. */
void geometry_drift(
    const struct geometry *geometry, const double *targets, double tool_length_mm, double drift[3]);

/* Puts down how the drift moves where targets and the tool's length move [mm]. */
void geometry_derive(
    const struct geometry *geometry, const double *targets, double tool_length_mm,
    const double *moved, double tool_moved_mm, double drift[3]);

/* Puts down how the drift follows from small targets: rows for X, Y, Z, each of count weights. */
void geometry_weights(
    const struct geometry *geometry, double tool_length_mm, size_t count, double *weights);

/* Puts down elongation [um], yaw and pitch [urad]; 0 for what the rig does not measure. */
void geometry_pose(const struct geometry *geometry, const double *targets, double pose[3]);

#endif
