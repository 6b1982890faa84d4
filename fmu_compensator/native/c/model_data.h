/* What one compensator file says, as constant data: the generated model_data.c defines it. */
#ifndef MODEL_DATA_H
#define MODEL_DATA_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#include "error_model.h"
#include "fields.h"
#include "model.h"

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
extern const struct field model_geometry;
extern const struct field model_error_model;
extern const bool model_corrects_itself; /* the error model takes measured targets its own way */
extern const struct derivatives compensator_derivatives; /* where that is linear in its inputs */
extern const struct field model_gaussian;
extern const struct field model_spare; /* FIELD_NULL: the file has none */
extern const struct error_model_kind *const model_kinds[];
extern const size_t model_kind_count;
extern const struct status_text model_status_texts[];
extern const size_t model_status_text_count;
extern const struct ports model_ports;

#endif
