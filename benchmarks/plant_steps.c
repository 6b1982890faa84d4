/* What each step of a plant costs by itself [ns]: the least of many runs of the same steps, each by an
   instance of its own, so that what else the machine does counts for nothing.

   plant_steps LIBRARY GUID RUNS INPUTS STEP_S SPEED...: one step at each speed, the first input; the
   others keep their start values. Prints a line for each step. */
#define _POSIX_C_SOURCE 200809L
#include <dlfcn.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <time.h>

#include "fmi2FunctionTypes.h"

#define MOST 1000

static void logger(
    fmi2ComponentEnvironment environment, fmi2String name, fmi2Status status, fmi2String category,
    fmi2String message, ...)
{
    (void)environment, (void)name, (void)category;
    fprintf(stderr, "%d: %s\n", (int)status, message);
}

/* ISO C has no conversion from a data pointer to a function pointer; POSIX asks for this one. */
static void find(void *library, const char *name, void *function)
{
    *(void **)function = dlsym(library, name);
    if (*(void **)function == NULL) {
        fprintf(stderr, "%s is missing\n", name);
        exit(1);
    }
}

static double now_ns(void)
{
    struct timespec now;
    clock_gettime(CLOCK_MONOTONIC, &now);
    return 1e9 * (double)now.tv_sec + (double)now.tv_nsec;
}

int main(int count, char **arguments)
{
    static const fmi2CallbackFunctions host = {logger, NULL, NULL, NULL, NULL};
    static fmi2ValueReference refs[MOST];
    static double in[MOST], least[MOST];
    fmi2InstantiateTYPE *instantiate;
    fmi2EnterInitializationModeTYPE *begin;
    fmi2ExitInitializationModeTYPE *start;
    fmi2FreeInstanceTYPE *release;
    fmi2SetRealTYPE *set;
    fmi2GetRealTYPE *get;
    fmi2DoStepTYPE *step;
    void *library = count > 6 ? dlopen(arguments[1], RTLD_NOW) : NULL;
    if (library == NULL || count - 6 > MOST) {
        fprintf(stderr, "usage: plant_steps LIBRARY GUID RUNS INPUTS STEP_S SPEED...\n");
        return 1;
    }
    find(library, "fmi2Instantiate", &instantiate);
    find(library, "fmi2EnterInitializationMode", &begin);
    find(library, "fmi2ExitInitializationMode", &start);
    find(library, "fmi2FreeInstance", &release);
    find(library, "fmi2SetReal", &set);
    find(library, "fmi2GetReal", &get);
    find(library, "fmi2DoStep", &step);
    int runs = atoi(arguments[3]), steps = count - 6;
    size_t inputs = (size_t)atol(arguments[4]);
    double step_s = atof(arguments[5]), idle = INFINITY;
    for (size_t i = 0; i < MOST; i++) {
        refs[i] = (fmi2ValueReference)i;
        least[i] = INFINITY;
    }
    for (int run = 0; run < runs; run++) {
        fmi2Component c = instantiate("one", fmi2CoSimulation, arguments[2], "", &host, 0, 1);
        if (c == NULL || inputs > MOST) {
            fprintf(stderr, "the FMU does not start\n");
            return 1;
        }
        int status = (int)begin(c) | (int)start(c) | (int)get(c, refs, inputs, in);
        for (int k = 0; k < steps; k++) {
            in[0] = atof(arguments[6 + k]);
            status |= (int)set(c, refs, inputs, in);
            double clock = now_ns(), before = now_ns();
            status |= (int)step(c, (double)k * step_s, step_s, 1);
            double after = now_ns();
            idle = fmin(idle, before - clock);
            least[k] = fmin(least[k], after - before);
        }
        release(c);
        if (status != 0) {
            fprintf(stderr, "a call was refused\n");
            return 1;
        }
    }
    for (int k = 0; k < steps; k++) {
        printf("%.1f\n", least[k] - idle);
    }
    return 0;
}
