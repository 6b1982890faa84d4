/* The compensator: one step takes the readings in and gives the axis offsets out. */
#ifndef COMPENSATOR_H
#define COMPENSATOR_H

#include <stdint.h>

#include "checks.h"
#include "constants.h"
#include "error_model.h"
#include "gaussian.h"
#include "geometry.h"
#include "setup.h"
#include "spare.h"

struct input {
    double time_s, step_s;
    const double *temperatures; /* one per sensor of the file; NaN: missing [degC] */
    double speed;               /* NaN: not known [rpm] */
    double tool_length;         /* [mm] */
    const double *measured;     /* the targets with this sample; NULL: not measured [um, urad] */
};

#define REAL_OUTPUTS 9 /* which come first */

/* The outputs have the names of the FMU's variables. */
struct output {
    double dX, dY, dZ;             /* offsets to send [um] */
    double elongation, yaw, pitch; /* the predicted pose [um, urad, urad] */
    double dX_uncertainty, dY_uncertainty, dZ_uncertainty; /* [um] */
    int32_t valid, status, status_sensor;
    int32_t also_without[GAUSSIAN_NAMED]; /* further broken sensors, from 1; 0: none */
    struct reason reason; /* what status_text is made of */
};

struct compensator {
    struct geometry geometry;
    struct gaussian gaussian;
    struct error_model *error_model;
    struct spare *spare;                          /* NULL: the file has none */
    size_t numbers;                               /* how long the row of numbers remembered is */
    bool *bad;                                    /* of one sample: which cannot be used */
    double *rises, *readings, *missed;            /* of one sample */
    double *axes;   /* how the drift along X, Y, Z follows from the targets; of the tool length */
    double *spread; /* root of a unit of variance along X, Y, Z [um], then that length [mm] */
    double *moved;  /* of derivatives, a number a target */
};

/* The parts of the row of numbers. */
struct parts {
    double *reference;
    struct sensor_memory *checks;
    double *measured, *targets, *gaussian, *spare, *error_model;
};

struct parts compensator_parts(const struct compensator *self, double *numbers);

/* What is remembered, beside the row of numbers: the reference of each chosen sensor, what its
   check remembers, the measured targets, the predicted ones, the states of Gaussian, spare and
   error model. NaN stands for nothing. */
struct remembered {
    double last_time, fault_age, good_for, unmodelled;
    double wanted[3], offset[3], pose[3], half_width[3];
    struct reason fault;  /* the newest, kept until recovered from; cause 0: none */
    struct reason spared; /* the newest of a sensor that is done without; cause 0: none */
    int32_t started, recovering, has_measured, predicted;
};

/* Makes it from the compiled-in file; whether that worked stands in the setup. */
void compensator_make(struct setup *setup, struct compensator *self);

/* Starts over: no reference, no offsets; the output is that before the first sample. */
void compensator_reset(
    const struct compensator *self, struct remembered *memory, double *numbers,
    struct output *output);

/* How the real outputs, in their order, follow from the temperatures, in the order of the file, and
   the tool's length [mm], in the direction of seeds, after a step with that length. */
void compensator_derive(
    const struct compensator *self, const struct remembered *memory, double *numbers,
    double tool_length, const double *seeds, double tool_seed, double found[REAL_OUTPUTS]);

/* Takes in one sample and puts down the offsets at the end of the step. */
void compensator_step(
    const struct compensator *self, struct remembered *memory, double *numbers,
    const struct input *input, struct output *output);

#endif
