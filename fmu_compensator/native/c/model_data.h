/* What one compensator file says, as constant data: the generated model_data.c defines it. */
#ifndef MODEL_DATA_H
#define MODEL_DATA_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#include "constants.h"
#include "error_model.h"
#include "fields.h"
#include "model.h"

/* So many sums are made side by side; a table in lanes has a row of them for each feature. */
#define LANES GAUSSIAN_MOST_PROBES

/* One temperature input; see the Python twin, checks.Sensor. */
struct sensor {
    const char *name;
    double low, high;                 /* plausible readings [degC] */
    double rate_per_s;                /* fastest real change [K/s] */
    double noise;                     /* largest jump that noise explains [K] */
    double stale_after_s;             /* unchanged for longer is stale [s]; NaN: never */
    double trained_low, trained_high; /* range seen in training [degC or K] */
};

/* What an offset may do; see limits.Limits. */
struct limits {
    double offset_um, slew_um_per_s, hold_s, recover_s;
    double tool_length_mm[2];
    double share; /* of the predicted drift that is sent [1] */
};

struct geometry_data {
    bool needs_tool_length; /* a rig with two radial sensors a direction; else a column an axis */
    double near_mm;         /* from the gauge line to where the radial drift is taken */
    double radial;          /* its share that counts: 0 where the spindle turns about the line */
    const double *weights;  /* how the drift follows from targets, with a tool of no length */
};

/* See gaussian.Gaussian. The last feature is 1: its weights are the constant drift. */
struct gaussian_data {
    size_t lags, width, tables; /* width: of a sample's features without that */
    double settled_h, walk_per_h, deviations;
    const double *usual; /* NULL: rises count from the first reading */
    const double *lags_s, *spread;
    const double *prior;      /* variance of each feature's weights over the noise's */
    const double *mean_share; /* of the error model's prediction [1] */
    const double *weights, *seen; /* in lanes: of the targets; tables of what training saw */
};

/* See spare.Spare. */
struct spare_data {
    double memory_s;
    const double *precision; /* NULL: the file has no spare */
    const double *growth, *usual;
    const double *sensitivity; /* a row a sensor */
    const double *usual_start; /* NULL: rises count from fixed temperatures */
};

struct status_text {
    int32_t status;
    const char *text;
};

/* Value references that the program must know. */
struct ports {
    size_t speed, tool_length;
    size_t measured_targets; /* of the first; the others follow */
    size_t measured;
};

extern const struct sensor model_sensors[];
extern const size_t model_sensor_count;
extern const size_t model_chosen[]; /* places of the sensors that the error model uses */
extern const size_t model_chosen_count;
extern const size_t model_target_count;
extern const bool model_takes_rises; /* temperatures minus their first valid reading */
extern const struct limits model_limits;
extern const struct geometry_data model_geometry;
extern const struct field model_error_model;
extern const bool model_uses_measured; /* the error model takes measured targets its own way */
extern const struct derivatives compensator_derivatives; /* where that is linear in its inputs */
extern const struct gaussian_data model_gaussian;
extern const struct spare_data model_spare;
extern const struct error_model_kind *const model_kinds[]; /* the last is NULL */
extern const struct status_text model_status_texts[]; /* the last has none */
extern const struct ports model_ports;

#endif
