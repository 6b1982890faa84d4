#include "geometry.h"

#include <math.h>
#include <string.h>

#include "numbers.h"

static void direct(const double *targets, double drift[3])
{
    for (size_t axis = 0; axis < 3; axis++) {
        const double *weights = model_geometry.weights + axis * model_target_count;
        drift[axis] = dot(weights, targets, model_target_count);
    }
}

/* dZ = L - (L + E) cos(theta), 1/cos^2(theta) = 1 + tan^2(yaw) + tan^2(pitch). */
void geometry_drift(const double *targets, double tool_length_mm, double drift[3])
{
    if (!model_geometry.needs_tool_length) {
        direct(targets, drift);
        return;
    }
    double slope_x = tan(targets[1] * GEOMETRY_RAD_PER_URAD);
    double slope_y = tan(targets[2] * GEOMETRY_RAD_PER_URAD);
    double squares = slope_x * slope_x + slope_y * slope_y, cosine = 1.0 / sqrt(1.0 + squares);
    double length = tool_length_mm * GEOMETRY_UM_PER_MM;
    double beyond = length - model_geometry.near_mm * GEOMETRY_UM_PER_MM;
    drift[0] = model_geometry.radial * targets[3] + beyond * slope_x;
    drift[1] = model_geometry.radial * targets[4] + beyond * slope_y;
    /* 1 - cosine, without the small difference of two long lengths. */
    drift[2] = length * (squares * cosine * cosine / (1.0 + cosine)) - targets[0] * cosine;
}

void geometry_derive(
    const double *targets, double tool_length_mm, const double *moved, double tool_moved_mm,
    double drift[3])
{
    if (!model_geometry.needs_tool_length) {
        direct(moved, drift);
        return;
    }
    double length = tool_length_mm * GEOMETRY_UM_PER_MM, sum = 1.0, change = 0.0;
    double beyond = length - model_geometry.near_mm * GEOMETRY_UM_PER_MM;
    double longer = tool_moved_mm * GEOMETRY_UM_PER_MM;
    for (size_t axis = 0; axis < 2; axis++) {
        double slope = tan(targets[1 + axis] * GEOMETRY_RAD_PER_URAD);
        double more = (1.0 + slope * slope) * moved[1 + axis] * GEOMETRY_RAD_PER_URAD;
        drift[axis] = longer * slope + beyond * more + model_geometry.radial * moved[3 + axis];
        sum += slope * slope;
        change += slope * more;
    }
    double cosine = 1.0 / sqrt(sum), shorter = cosine * change / sum;
    drift[2] = longer - (longer + moved[0]) * cosine + (length + targets[0]) * shorter;
}

void geometry_weights(double tool_length_mm, double *weights)
{
    size_t count = model_target_count;
    double arm_mm = tool_length_mm - model_geometry.near_mm;
    memcpy(weights, model_geometry.weights, 3 * count * sizeof(double));
    if (model_geometry.needs_tool_length) {
        weights[1] = weights[count + 2] = arm_mm * GEOMETRY_UM_PER_MM * GEOMETRY_RAD_PER_URAD;
    }
}

void geometry_pose(const double *targets, double pose[3])
{
    double drift[3];
    if (model_geometry.needs_tool_length) {
        memcpy(pose, targets, 3 * sizeof(double));
        return;
    }
    direct(targets, drift);
    pose[0] = 0.0 - drift[2];
    pose[1] = pose[2] = 0.0;
}
