/* What a model gives the FMI front: its variables, and how an instance starts and steps. */
#ifndef MODEL_H
#define MODEL_H

#include <math.h>
#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#include "setup.h"

enum kind { REAL, INTEGER, BOOLEAN, STRING };
/* A tunable parameter may be set between steps; the next one goes on with it. What a bus has
   received or sent stands among the values. */
enum causality { INPUT, OUTPUT, PARAMETER, TUNABLE_PARAMETER, DERIVATIVE, RECEIVED, SENT };

/* One variable of the FMU; its place in the table is its value reference. */
struct variable {
    const char *name;
    enum kind kind;
    enum causality causality;
    double start;  /* of an input or a parameter */
    size_t offset; /* of an output, in the content; of a derivative, among them */
};

#define NONE ((size_t)-1)
#define PROBLEM_LENGTH 640 /* room for a sentence that says what is wrong */

extern const char *const model_guid;
extern const char *const model_name;
extern const struct variable model_variables[];
extern const size_t model_variable_count;
/* In FMI 3.0, variables in a row may be one array, under the reference of the first. */
extern const struct array { size_t first, count; } model_array;
extern const bool model_clock_may_jump; /* a step need not begin where the one before ended */

/* By how much a host's clock may be off in a step: what single precision leaves of it, and half a
   step at most, so that it cannot be another step. */
static inline double clock_slack(double time_s, double step_s)
{
    return fmin(0x1p-23 * (fabs(time_s) + 1.0), fabs(step_s) / 2.0);
}

/* What an instance computes with, and what it remembers: each model has its own. All that changes
   and counts is in the content, which begins with the outputs and is copied as bytes. */
struct model;

struct model *model_make(struct setup *setup, size_t *content_size);

/* Brings the content back to what it is before the start. */
void model_reset(struct model *self, void *content);

/* Starts at a time with the values of all variables, by value reference; what is wrong, NULL for
   nothing. It may be called more than once. problem has room for a sentence. */
const char *model_start(
    struct model *self, void *content, const double *values, double time_s,
    char problem[PROBLEM_LENGTH]);

/* Advances by a step that is above 0 and finite; what is wrong, NULL for nothing, and then the
   content is as before. */
const char *model_step(
    struct model *self, void *content, const double *values, double time_s, double step_s,
    char problem[PROBLEM_LENGTH]);

/* What model exchange needs of a model whose states are all continuous. Its functions say what is
   wrong, NULL for nothing. */
struct continuous {
    size_t count;  /* of states, */
    size_t offset; /* which stand in a row in the content */
    const double *nominals;
    const char *(*rates)(
        struct model *self, const void *content, const double *values, double *rates,
        char problem[PROBLEM_LENGTH]);
    /* Brings the outputs to a time and to the states and values as they are. */
    const char *(*show)(
        struct model *self, void *content, const double *values, double time_s,
        char problem[PROBLEM_LENGTH]);
    /* A solver's step has ended at a time: what is not continuous, and moves no state, goes on. */
    const char *(*complete)(
        struct model *self, void *content, const double *values, double time_s,
        char problem[PROBLEM_LENGTH]);
};

extern const struct continuous *const model_continuous; /* NULL: for co-simulation only */

enum side { KNOWN, UNKNOWN };

/* Derivatives by what is known (inputs, states, parameters) of what is not (outputs, rates):
   forward a direction among the known gives how the unknown change; backward weights of the unknown
   give how their sum changes with each known. */
struct derivatives {
    size_t (*place)(enum side side, size_t ref); /* of a variable on its side; NONE: not there */
    const char *(*derive)(
        struct model *self, const void *content, const double *values, double time_s,
        enum side from, const double *seeds, double *found, char problem[PROBLEM_LENGTH]);
};

extern const struct derivatives *const model_derivatives; /* NULL: there are none */

/* Writes the text output. */
void model_text(const void *content, char text[PROBLEM_LENGTH]);

/* Where the text parameter is kept, and its size; NULL where there is none. */
char *model_text_parameter(void *content, size_t *size);

#endif
