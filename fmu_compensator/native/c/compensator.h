/* The compensator: each step takes readings and returns axis offsets. */
#ifndef COMPENSATOR_H
#define COMPENSATOR_H

#include <stdint.h>

#include "checks.h"
#include "gaussian.h"
#include "setup.h"
#include "spare.h"

#define FILE_LENGTH 1024 /* of the text of the parameter model_file */
#define REAL_OUTPUTS 9   /* these come first */
#define SPEED_NUMBER ((int32_t)model_sensor_count + 1) /* of the speed among the sensors */

struct input {
    double time_s, step_s;
    const double *temperatures; /* one per sensor of the file; NaN: missing [degC] */
    double speed;               /* NaN: unknown [rpm] */
    double tool_length;         /* [mm] */
    const double *measured;     /* the targets with this sample; NULL: not measured [um, urad] */
};

struct output {
    double offset[3];     /* to send [um] */
    double pose[3];       /* predicted [um, urad, urad] */
    double half_width[3]; /* [um] */
    int32_t valid, status, status_sensor;
    int32_t others[GAUSSIAN_NAMED]; /* further inputs that the text names, from 1; 0: none */
    struct reason reason;           /* data for the text */
};

/* Memory of an instance; NaN: none. */
struct content {
    struct output output;
    double last_time, fault_age, good_for, unmodelled, wanted[3];
    double measured[LANES], targets[LANES]; /* [um, urad] */
    struct reason fault;  /* the newest, kept until recovered from; cause 0: none */
    struct reason spared; /* the newest of a sensor that is replaced; cause 0: none */
    int32_t started, recovering, has_measured;
    char model_file[FILE_LENGTH];
    double numbers[]; /* memory of the sensors, Gaussian, spare and error model */
};

/* Its parts, and pointers into its content. */
struct compensator {
    size_t size; /* of its content */
    struct error_model *error_model;
    struct gaussian gaussian;
    struct spare spare;
    struct content *now;
    struct sensor_memory *sensors;
    struct gaussian_state *learnt;
    struct spare_state *spared;
    double *mean;              /* of the error model */
    bool *bad;                 /* of one sample: sensors that cannot be used */
    bool unheard;              /* of one sample: the speed is missing */
    double *rises, *readings;  /* of one sample */
    double missed[LANES], moved[LANES];
    double tool_length;     /* for which the following are valid, for X, Y and Z [mm] */
    double spread[3];       /* the root of a unit of variance [um] */
    double axes[3 * LANES]; /* derivatives of the drift by the targets, row by row */
};

/* Makes it from the compiled-in file; the setup tells whether that worked. */
void compensator_make(struct setup *setup, struct compensator *self);

/* Starts over: no reference, no offsets; the output is that before the first sample. */
void compensator_reset(struct compensator *self, struct content *content);

/* Returns an axis' weight of a column of the root of the noise's covariance [um]. */
double compensator_noise(const struct compensator *self, size_t axis, size_t column);

/* Computes the error model's weighted prediction for a sample [um, urad]. */
void compensator_mean(struct compensator *self, const struct sample *sample, double *mean);

/* Returns the variance of the drift along an axis [um^2]. */
double compensator_variance(const struct compensator *self, size_t axis);

/* Directional derivatives of the real outputs, in their order, by the temperatures (seeds in the
   file's order) and the tool length [mm], after a step with that length. */
void compensator_derive(
    struct compensator *self, double tool_length, const double *seeds, double tool_seed,
    double found[REAL_OUTPUTS]);

/* Processes one sample and computes the offsets at the end of the step. */
void compensator_step(
    struct compensator *self, struct content *content, const struct input *input);

/* Writes the status text, identical to that of the Python twin. */
void status_text(const struct output *output, char *text, size_t size);

#endif
