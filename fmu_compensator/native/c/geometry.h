/* From predicted quantities to the drift of the tool tip. */
#ifndef GEOMETRY_H
#define GEOMETRY_H

#include "model_data.h"

/* Puts down the tool tip's drift along +X, +Y and +Z [um]. */
void geometry_drift(const double *targets, double tool_length_mm, double drift[3]);

/* Puts down how the drift moves where targets and the tool's length move [mm]. */
void geometry_derive(
    const double *targets, double tool_length_mm, const double *moved, double tool_moved_mm,
    double drift[3]);

/* Puts down how the drift follows from small targets: rows for X, Y, Z, with a weight a target. */
void geometry_weights(double tool_length_mm, double *weights);

/* Puts down elongation [um], yaw and pitch [urad]; 0 for what the rig does not measure. */
void geometry_pose(const double *targets, double pose[3]);

#endif
