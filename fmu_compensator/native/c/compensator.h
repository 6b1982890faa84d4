/* The compensator: one step takes the readings in and gives the axis offsets out. */
#ifndef COMPENSATOR_H
#define COMPENSATOR_H

#include <stdint.h>

#include "checks.h"
#include "gaussian.h"
#include "setup.h"
#include "spare.h"

#define FILE_LENGTH 1024 /* of the text of the parameter model_file */
#define REAL_OUTPUTS 9   /* which come first */

struct input {
    double time_s, step_s;
    const double *temperatures; /* one per sensor of the file; NaN: missing [degC] */
    double speed;               /* NaN: not known [rpm] */
    double tool_length;         /* [mm] */
    const double *measured;     /* the targets with this sample; NULL: not measured [um, urad] */
};

struct output {
    double offset[3];     /* to send [um] */
    double pose[3];       /* as predicted [um, urad, urad] */
    double half_width[3]; /* [um] */
    int32_t valid, status, status_sensor;
    int32_t others[GAUSSIAN_NAMED]; /* further sensors that the text names, from 1; 0: none */
    struct reason reason;           /* what the text is made of */
};

/* What an instance remembers; NaN stands for nothing. */
struct content {
    struct output output;
    double last_time, fault_age, good_for, unmodelled, wanted[3];
    double measured[LANES], targets[LANES]; /* [um, urad] */
    struct reason fault;  /* the newest, kept until recovered from; cause 0: none */
    struct reason spared; /* the newest of a sensor that is done without; cause 0: none */
    int32_t started, recovering, has_measured;
    char model_file[FILE_LENGTH];
    double numbers[]; /* what is remembered of the sensors, by Gaussian, spare and error model */
};

/* What it computes with, and where the parts of its content are. */
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
    bool *bad;                 /* of one sample: which cannot be used */
    double *rises, *readings;  /* of one sample */
    double missed[LANES], moved[LANES];
    double tool_length;     /* that what follows is of: for X, Y and Z [mm] */
    double spread[3];       /* the root of a unit of variance [um] */
    double axes[3 * LANES]; /* how the drift follows from the targets, row by row */
};

/* Makes it from the compiled-in file; whether that worked stands in the setup. */
void compensator_make(struct setup *setup, struct compensator *self);

/* Starts over: no reference, no offsets; the output is that before the first sample. */
void compensator_reset(struct compensator *self, struct content *content);

/* Puts down what the error model says of a sample, as far as it counts [um, urad]. */
void compensator_mean(struct compensator *self, const struct sample *sample, double *mean);

/* Returns the variance of the drift along an axis [um^2]. */
double compensator_variance(const struct compensator *self, size_t axis);

/* How the real outputs, in their order, follow from the temperatures, in the order of the file, and
   the tool's length [mm], in the direction of seeds, after a step with that length. */
void compensator_derive(
    struct compensator *self, double tool_length, const double *seeds, double tool_seed,
    double found[REAL_OUTPUTS]);

/* Takes in one sample and puts down the offsets at the end of the step. */
void compensator_step(
    struct compensator *self, struct content *content, const struct input *input);

/* Writes the status in words, letter for letter those of the Python twin. */
void status_text(const struct output *output, char *text, size_t size);

#endif
