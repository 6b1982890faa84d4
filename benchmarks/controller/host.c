/* Steps an FMU whose sources it is linked with, and prints what each step takes [ns].

   host STEPS RUNS: the same steps in each of the runs, each run from the start. Of each step the
   shortest time counts, because only the rest of the computer makes it longer. Prints the median and
   the longest of these, and the time of a chain of a thousand multiplications and additions.
   For a controller it is linked to see how large that is; there nothing is printed. */
#define _POSIX_C_SOURCE 200809L
#include <math.h>
#include <stdint.h>
#include <string.h>

#include "fmi2Functions.h"
#include "model.h"

#define MOST 20000
#define CHAIN 1000

static uint64_t random_state;

static double drawn(void)
{
    random_state = random_state * 6364136223846793005u + 1442695040888963407u;
    return (double)(random_state >> 11) / 9007199254740992.0;
}

static void set_inputs(fmi2Component c, int k)
{
    static double speed;
    if (k % 50 == 0 || (k / 200) % 2 == 1) {
        speed = 12000.0 * drawn(); /* one that stays, and one that is another in each step */
    }
    for (fmi2ValueReference ref = 0; ref < model_variable_count; ref++) {
        const struct variable *variable = &model_variables[ref];
        double value = 20.0 + 1e-3 * k + 0.1 * drawn(); /* a thermometer */
        if (variable->causality != INPUT || variable->kind != REAL) {
            continue;
        }
        if (strcmp(variable->name, "speed") == 0) {
            value = speed;
        } else if (variable->start != 0.0 && strcmp(variable->name, "tool_length") == 0) {
            value = 150.0;
        } else if (variable->name[0] == 'd') {
            value = 50.0 * drawn();
        } else if (variable->name[0] == 'T' && drawn() < 0.002) {
            value = NAN;
        }
        (void)fmi2SetReal(c, &ref, 1, &value);
    }
}

static fmi2Component started(void)
{
    static const fmi2CallbackFunctions host = {NULL, NULL, NULL, NULL, NULL};
    fmi2Component c = fmi2Instantiate("c", fmi2CoSimulation, model_guid, "", &host, 0, 0);
    random_state = 1;
    (void)fmi2EnterInitializationMode(c);
    (void)fmi2ExitInitializationMode(c);
    return c;
}

static double read_outputs(fmi2Component c)
{
    double sum = 0.0, value = 0.0;
    for (fmi2ValueReference ref = 0; ref < model_variable_count; ref++) {
        if (model_variables[ref].causality == OUTPUT && model_variables[ref].kind == REAL) {
            (void)fmi2GetReal(c, &ref, 1, &value);
            sum += value;
        }
    }
    return sum;
}

#ifdef CONTROLLER

int main(void)
{
    volatile double seen = 0.0;
    fmi2Component c = started();
    for (int k = 0;; k++) {
        set_inputs(c, k);
        (void)fmi2DoStep(c, (double)k, 1.0, 1);
        seen = read_outputs(c);
        (void)seen;
    }
}

#else

#include <stdio.h>
#include <stdlib.h>
#include <time.h>

static double least[MOST];

static double now(void)
{
    struct timespec at;
    clock_gettime(CLOCK_MONOTONIC, &at);
    return 1e9 * (double)at.tv_sec + (double)at.tv_nsec;
}

static int compared(const void *one, const void *other)
{
    double a = *(const double *)one, b = *(const double *)other;
    return (a > b) - (a < b);
}

int main(int count, char **arguments)
{
    int steps = count == 3 ? atoi(arguments[1]) : 0, runs = count == 3 ? atoi(arguments[2]) : 0;
    volatile double seen = 0.0, one = 1.0;
    double chain = INFINITY;
    int status = 0;
    for (int run = 0; run < runs; run++) {
        fmi2Component c = started();
        for (int k = 0; k < steps && k < MOST; k++) {
            set_inputs(c, k);
            double begun = now();
            status |= (int)fmi2DoStep(c, (double)k, 1.0, 1);
            double spent = now() - begun;
            least[k] = run == 0 || spent < least[k] ? spent : least[k];
            seen = read_outputs(c);
        }
        fmi2FreeInstance(c);
        double sum = seen, begun = now(), factor = one;
        for (int i = 0; i < CHAIN; i++) {
            sum = sum * factor + 1.0;
        }
        seen = sum;
        double spent = now() - begun;
        chain = spent < chain ? spent : chain;
    }
    qsort(least, (size_t)steps, sizeof least[0], compared);
    printf("%.0f %.0f %.0f\n", least[steps / 2], least[steps - 1], chain);
    return status;
}

#endif
