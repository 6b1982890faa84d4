/* One compensator file as constant data, defined by the generated model_data.c. */
#ifndef MODEL_DATA_H
#define MODEL_DATA_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#include "constants.h"
#include "error_model.h"
#include "fields.h"
#include "model.h"

/* Number of sums computed side by side; a table in lanes has one such row per feature. */
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

/* Limits of the offsets; see limits.Limits. */
struct limits {
    double offset_um, slew_um_per_s, hold_s, recover_s;
    double tool_length_mm[2];
    double share; /* of the predicted drift that is compensated [1] */
};

struct geometry_data {
    bool needs_tool_length; /* two radial sensors per direction; else one column per axis */
    double near_mm;         /* from the gauge line to where the radial drift is taken */
    double radial;          /* its weight: 0 if the spindle turns about the gauge line */
    const double *weights;  /* derivatives of the drift by the targets, for tool length 0 */
};

/* See gaussian.Gaussian. The last feature is 1: its weights are the constant drift. */
struct gaussian_data {
    size_t lags, width, tables; /* width: number of a sample's features without the last */
    size_t inputs;
    double settled_h, walk_per_h, deviations;
    double speed_rpm; /* that counts like a rise of 1 K; 0: speed is not used */
    const double *usual; /* NULL: rises count from the first reading */
    const double *lags_s;
    const double *spread;     /* standard deviation of each target's noise */
    const double *noise;      /* root of its covariance: column by column */
    const double *prior;      /* variance of each feature's weights over the noise's */
    const double *mean_share; /* of the error model's prediction [1] */
    const double *weights, *seen; /* in lanes: of the targets; rows d of training */
};

/* See spare.Spare. */
struct spare_data {
    double memory_s;
    const double *precision; /* NULL: the file has no spare */
    const double *growth;
    const double *sensitivity; /* one row per sensor */
    const double *usual_start; /* NULL: rises count from fixed temperatures */
};

struct status_text {
    int32_t status;
    const char *text;
};

/* Value references that the program needs. */
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
extern const bool model_uses_measured; /* the error model itself uses measured targets */
extern const struct derivatives compensator_derivatives; /* if it is linear in its inputs */
extern const struct gaussian_data model_gaussian;
extern const struct spare_data model_spare;
extern const struct error_model_kind *const model_kinds[]; /* the last is NULL */
extern const struct status_text model_status_texts[]; /* the last has none */
extern const struct ports model_ports;

#endif
