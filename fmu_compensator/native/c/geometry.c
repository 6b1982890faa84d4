#include "geometry.h"

#include <math.h>
#include <string.h>

#include "constants.h"

static void make_columns(
    struct setup *setup, const struct field *table, struct geometry *geometry)
{
    const struct field *axes = field_table(setup, table, "axes");
    if (axes == NULL || axes->count > 3) {
        setup_fail(setup, "the compiled-in file measures too many", "axes");
        return;
    }
    geometry->columns = axes->count;
    for (size_t i = 0; i < axes->count; i++) {
        const char *axis = field_text(setup, &axes->items[i], "axis");
        geometry->axis[i] = axis[0] == 'Y' ? 1 : axis[0] == 'Z' ? 2 : 0;
        geometry->sign[i] = field_number(setup, &axes->items[i], "sign");
    }
}

void geometry_make(struct setup *setup, const struct field *table, struct geometry *geometry)
{
    geometry->needs_tool_length = strcmp(field_text(setup, table, "kind"), "five_point") == 0;
    if (geometry->needs_tool_length) {
        geometry->pure_rotation = strcmp(field_text(setup, table, "form"), "pure_rotation") == 0;
        geometry->near_to_gauge_mm = field_number(setup, table, "near_to_gauge_mm");
    } else {
        make_columns(setup, table, geometry);
    }
}

/* dZ = L - (L + E) cos(theta), 1/cos^2(theta) = 1 + tan^2(yaw) + tan^2(pitch). */
static void five_point(
    const struct geometry *geometry, const double *targets, double tool_length_mm, double drift[3])
{
    double elongation = targets[0], near_x = targets[3], near_y = targets[4];
    double slope_x = tan(targets[1] * GEOMETRY_RAD_PER_URAD);
    double slope_y = tan(targets[2] * GEOMETRY_RAD_PER_URAD);
    double length = tool_length_mm * GEOMETRY_UM_PER_MM;
    double cosine = 1.0 / sqrt(1.0 + slope_x * slope_x + slope_y * slope_y);
    double beyond = length - geometry->near_to_gauge_mm * GEOMETRY_UM_PER_MM;
    drift[0] = geometry->pure_rotation ? length * slope_x : near_x + beyond * slope_x;
    drift[1] = geometry->pure_rotation ? length * slope_y : near_y + beyond * slope_y;
    drift[2] = length - (length + elongation) * cosine;
}

void geometry_drift(
    const struct geometry *geometry, const double *targets, double tool_length_mm, double drift[3])
{
    if (geometry->needs_tool_length) {
        five_point(geometry, targets, tool_length_mm, drift);
        return;
    }
    drift[0] = drift[1] = drift[2] = 0.0;
    for (size_t i = 0; i < geometry->columns; i++) {
        drift[geometry->axis[i]] = geometry->sign[i] * targets[i];
    }
}

void geometry_derive(
    const struct geometry *geometry, const double *targets, double tool_length_mm,
    const double *moved, double tool_moved_mm, double drift[3])
{
    if (!geometry->needs_tool_length) {
        geometry_drift(geometry, moved, 0.0, drift);
        return;
    }
    double length = tool_length_mm * GEOMETRY_UM_PER_MM, longer = tool_moved_mm * GEOMETRY_UM_PER_MM;
    double near = geometry->pure_rotation ? 0.0 : geometry->near_to_gauge_mm * GEOMETRY_UM_PER_MM;
    double sum = 1.0, change = 0.0;
    for (size_t axis = 0; axis < 2; axis++) {
        double slope = tan(targets[1 + axis] * GEOMETRY_RAD_PER_URAD);
        double more = (1.0 + slope * slope) * moved[1 + axis] * GEOMETRY_RAD_PER_URAD;
        drift[axis] = longer * slope + (length - near) * more;
        drift[axis] += geometry->pure_rotation ? 0.0 : moved[3 + axis];
        sum += slope * slope;
        change += slope * more;
    }
    double cosine = 1.0 / sqrt(sum);
    drift[2] = longer - (longer + moved[0]) * cosine + (length + targets[0]) * cosine * change / sum;
}

void geometry_weights(
    const struct geometry *geometry, double tool_length_mm, size_t count, double *weights)
{
    double near_mm = geometry->pure_rotation ? 0.0 : geometry->near_to_gauge_mm;
    memset(weights, 0, 3 * count * sizeof(double));
    for (size_t i = 0; i < geometry->columns; i++) {
        weights[geometry->axis[i] * count + i] = geometry->sign[i];
    }
    if (geometry->needs_tool_length) {
        double slope = (tool_length_mm - near_mm) * GEOMETRY_UM_PER_MM * GEOMETRY_RAD_PER_URAD;
        weights[1] = weights[count + 2] = slope;
        weights[3] = weights[count + 4] = geometry->pure_rotation ? 0.0 : 1.0;
        weights[2 * count] = -1.0;
    }
}

void geometry_pose(const struct geometry *geometry, const double *targets, double pose[3])
{
    pose[0] = pose[1] = pose[2] = 0.0;
    if (geometry->needs_tool_length) {
        for (size_t i = 0; i < 3; i++) {
            pose[i] = targets[i];
        }
        return;
    }
    for (size_t i = 0; i < geometry->columns; i++) {
        if (geometry->axis[i] == 2) {
            pose[0] = -(geometry->sign[i] * targets[i]);
        }
    }
}
