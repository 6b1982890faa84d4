/* The smallest host of a plant: sets the inputs, steps, gets the outputs, and prints what a step
   took [ns].

   plant_host LIBRARY GUID STEPS INPUTS FIRST OUTPUTS SPEED...: the inputs are the value references
   from 0 on and keep their values but for the first, the speed, which goes through the values given,
   over and over, plus a millionth of the step's number where there are several; the outputs are
   those from FIRST on. */
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
    void *library = count > 7 ? dlopen(arguments[1], RTLD_NOW) : NULL;
    if (library == NULL) {
        fprintf(stderr, "usage: plant_host LIBRARY GUID STEPS INPUTS FIRST OUTPUTS SPEED...\n");
        return 1;
    }
    find(library, "fmi2Instantiate", &instantiate);
    find(library, "fmi2EnterInitializationMode", &begin);
    find(library, "fmi2ExitInitializationMode", &start);
    find(library, "fmi2SetReal", &set);
    find(library, "fmi2GetReal", &get);
    find(library, "fmi2DoStep", &step);
    find(library, "fmi2FreeInstance", &release);
    long steps = atol(arguments[3]), speeds = count - 7;
    size_t inputs = (size_t)atol(arguments[4]), outputs = (size_t)atol(arguments[6]);
    fmi2Component c = instantiate("one", fmi2CoSimulation, arguments[2], "", &host, 0, 1);
    if (c == NULL || inputs > MOST || begin(c) != fmi2OK || start(c) != fmi2OK) {
        fprintf(stderr, "the FMU does not start\n");
        return 1;
    }
    for (size_t i = 0; i < MOST; i++) {
        in_refs[i] = (fmi2ValueReference)i;
        out_refs[i] = (fmi2ValueReference)((size_t)atol(arguments[5]) + i);
    }
    struct timespec before, after;
    int status = (int)get(c, in_refs, inputs, in);
    clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &before);
    for (long k = 0; k < steps; k++) {
        in[0] = atof(arguments[7 + k % speeds]) + (speeds > 1 ? 1e-6 * (double)k : 0.0);
        status |= (int)set(c, in_refs, inputs, in);
        status |= (int)step(c, (double)k, 1.0, 1);
        status |= (int)get(c, out_refs, outputs, out);
    }
    clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &after);
    double seconds = (double)(after.tv_sec - before.tv_sec);
    seconds += 1e-9 * (double)(after.tv_nsec - before.tv_nsec);
    printf("%.17g %.17g\n", 1e9 * seconds / (double)steps, out[outputs - 1]);
    release(c);
    return status == 0 ? 0 : 1;
}
