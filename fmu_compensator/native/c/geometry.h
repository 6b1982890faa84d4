/* From predicted quantities to the drift of the tool tip. */
#ifndef GEOMETRY_H
#define GEOMETRY_H

#include "model_data.h"

/* Computes the tool tip's drift along +X, +Y and +Z [um]. */
void geometry_drift(const double *targets, double tool_length_mm, double drift[3]);

/* Computes the directional derivative of the drift by the targets and the tool length [mm]. */
void geometry_derive(
    const double *targets, double tool_length_mm, const double *moved, double tool_moved_mm,
    double drift[3]);

/* Computes the derivatives of the drift at zero: rows X, Y, Z, one weight per target. */
void geometry_weights(double tool_length_mm, double *weights);

/* Computes elongation [um], yaw and pitch [urad]; 0 if the rig does not measure them. */
void geometry_pose(const double *targets, double pose[3]);

#endif
