/* Interface of a model to the FMI front: its variables, and how an instance starts and steps. */
#ifndef MODEL_H
#define MODEL_H

#include <math.h>
#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#include "setup.h"

enum kind { REAL, INTEGER, BOOLEAN, STRING };
/* A tunable parameter may be set between steps and takes effect in the next. Data received or sent
   on a bus is among the values. */
enum causality { INPUT, OUTPUT, PARAMETER, TUNABLE_PARAMETER, DERIVATIVE, RECEIVED, SENT };

/* One variable of the FMU; its place in the table is its value reference. */
struct variable {
    const char *name;
    enum kind kind;
    enum causality causality;
    double start;  /* of an input or a parameter */
    size_t offset; /* of an output in the content; of a derivative among the rates */
};

#define NONE ((size_t)-1)
#define PROBLEM_LENGTH 640 /* room for an error message */

extern const char *const model_guid;
extern const char *const model_name;
extern const struct variable model_variables[];
extern const size_t model_variable_count;
/* In FMI 3.0, consecutive variables may be one array, with the reference of the first. */
extern const struct array { size_t first, count; } model_array;
extern const bool model_clock_may_jump; /* a step need not begin at the end of the previous one */

/* Tolerance for a host's clock in a step: its resolution in single precision, but at most half a
   step, so that it cannot be another step. */
static inline double clock_slack(double time_s, double step_s)
{
    return fmin(0x1p-23 * (fabs(time_s) + 1.0), fabs(step_s) / 2.0);
}

/* The data of an instance, defined by each model. The whole state is in the content, which begins
   with the outputs and is copied as bytes. */
struct model;

struct model *model_make(struct setup *setup, size_t *content_size);

/* Resets the content to its state before the start. */
void model_reset(struct model *self, void *content);

/* Starts at a time with the values of all variables, by value reference; returns an error message,
   or NULL. It may be called more than once. problem is room for a message. */
const char *model_start(
    struct model *self, void *content, const double *values, double time_s,
    char problem[PROBLEM_LENGTH]);

/* Advances by a step that is above 0 and finite; returns NULL, or an error message with the content
   unchanged. */
const char *model_step(
    struct model *self, void *content, const double *values, double time_s, double step_s,
    char problem[PROBLEM_LENGTH]);

/* The interface for model exchange of a model whose states are all continuous. Its functions return
   an error message, or NULL. */
struct continuous {
    size_t count;  /* of states */
    size_t offset; /* of the states, which are contiguous in the content */
    const double *nominals;
    const char *(*rates)(
        struct model *self, const void *content, const double *values, double *rates,
        char problem[PROBLEM_LENGTH]);
    /* Updates the outputs to a time and to the current states and values. */
    const char *(*show)(
        struct model *self, void *content, const double *values, double time_s,
        char problem[PROBLEM_LENGTH]);
    /* A solver's step has ended: advances what is not continuous and does not affect states. */
    const char *(*complete)(
        struct model *self, void *content, const double *values, double time_s,
        char problem[PROBLEM_LENGTH]);
};

extern const struct continuous *const model_continuous; /* NULL: for co-simulation only */

enum side { KNOWN, UNKNOWN };

/* Derivatives of the unknowns (outputs, rates) by the knowns (inputs, states, parameters). Forward:
   from a direction of the knowns to the change of the unknowns. Backward: from weights of the
   unknowns to the derivatives of their weighted sum by each known. */
struct derivatives {
    size_t (*place)(enum side side, size_t ref); /* of a variable on its side; NONE: not on it */
    const char *(*derive)(
        struct model *self, const void *content, const double *values, double time_s,
        enum side from, const double *seeds, double *found, char problem[PROBLEM_LENGTH]);
};

extern const struct derivatives *const model_derivatives; /* NULL: there are none */

/* Writes the text output. */
void model_text(const void *content, char text[PROBLEM_LENGTH]);

/* Returns the address of the text parameter, and its size; NULL if there is none. */
char *model_text_parameter(void *content, size_t *size);

#endif
