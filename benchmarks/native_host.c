/* The smallest host: sets the inputs, steps, gets the outputs, and prints what a step took [ns].

   native_host LIBRARY GUID STEPS INPUTS TOOL FIRST OUTPUTS: the inputs are the value references from
   0 on, TOOL is that of the tool length, the outputs are those from FIRST on. All other inputs start
   at 20 and rise, each a little faster. */
#define _POSIX_C_SOURCE 200809L
#include <dlfcn.h>
#include <stdio.h>
#include <stdlib.h>
#include <time.h>

#include "fmi2FunctionTypes.h"

#define MOST 1000

static void logger(
    fmi2ComponentEnvironment environment, fmi2String name, fmi2Status status, fmi2String category,
    fmi2String message, ...)
{
    (void)environment, (void)name, (void)status, (void)category, (void)message;
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

int main(int count, char **arguments)
{
    static const fmi2CallbackFunctions host = {logger, NULL, NULL, NULL, NULL};
    static fmi2ValueReference in_refs[MOST], out_refs[MOST];
    static double in[MOST], out[MOST];
    fmi2InstantiateTYPE *instantiate;
    fmi2EnterInitializationModeTYPE *begin;
    fmi2ExitInitializationModeTYPE *start;
    fmi2SetRealTYPE *set;
    fmi2GetRealTYPE *get;
    fmi2DoStepTYPE *step;
    fmi2FreeInstanceTYPE *release;
    void *library = count == 8 ? dlopen(arguments[1], RTLD_NOW) : NULL;
    if (library == NULL) {
        fprintf(stderr, "usage: native_host LIBRARY GUID STEPS INPUTS TOOL FIRST OUTPUTS\n");
        return 1;
    }
    find(library, "fmi2Instantiate", &instantiate);
    find(library, "fmi2EnterInitializationMode", &begin);
    find(library, "fmi2ExitInitializationMode", &start);
    find(library, "fmi2SetReal", &set);
    find(library, "fmi2GetReal", &get);
    find(library, "fmi2DoStep", &step);
    find(library, "fmi2FreeInstance", &release);
    long steps = atol(arguments[3]);
    size_t inputs = (size_t)atol(arguments[4]), tool = (size_t)atol(arguments[5]);
    size_t first = (size_t)atol(arguments[6]), outputs = (size_t)atol(arguments[7]);
    fmi2Component c = instantiate("one", fmi2CoSimulation, arguments[2], "", &host, 0, 0);
    if (c == NULL || inputs > MOST || outputs > MOST || tool >= inputs || begin(c) != fmi2OK
        || start(c) != fmi2OK) {
        fprintf(stderr, "the FMU does not start\n");
        return 1;
    }
    for (size_t i = 0; i < MOST; i++) {
        in_refs[i] = (fmi2ValueReference)i;
        out_refs[i] = (fmi2ValueReference)(first + i);
    }
    struct timespec before, after;
    int status = 0;
    clock_gettime(CLOCK_MONOTONIC, &before);
    for (long k = 0; k < steps; k++) {
        for (size_t i = 0; i < inputs; i++) {
            in[i] = 20.0 + 1e-6 * (double)(i + 1) * (double)k;
        }
        in[tool] = 100.0;
        status |= (int)set(c, in_refs, inputs, in);
        status |= (int)step(c, (double)k, 1.0, 1);
        status |= (int)get(c, out_refs, outputs, out);
    }
    clock_gettime(CLOCK_MONOTONIC, &after);
    double seconds = (double)(after.tv_sec - before.tv_sec);
    seconds += 1e-9 * (double)(after.tv_nsec - before.tv_nsec);
    printf("%.3f %d\n", 1e9 * seconds / (double)steps, status);
    release(c);
    return status;
}
