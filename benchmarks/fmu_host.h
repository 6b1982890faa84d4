/* What the small hosts share: an FMU's library (FMI 2.0), and an instance of it that has started. */
#ifndef FMU_HOST_H
#define FMU_HOST_H

#define _POSIX_C_SOURCE 200809L
#include <dlfcn.h>
#include <stdio.h>
#include <stdlib.h>
#include <time.h>

#include "fmi2FunctionTypes.h"

#define MOST 1000 /* variables of a kind */

static struct {
    fmi2InstantiateTYPE *instantiate;
    fmi2EnterInitializationModeTYPE *begin;
    fmi2ExitInitializationModeTYPE *start;
    fmi2SetRealTYPE *set;
    fmi2GetRealTYPE *get;
    fmi2DoStepTYPE *step;
    fmi2FreeInstanceTYPE *release;
} fmu;

static void logger(
    fmi2ComponentEnvironment environment, fmi2String name, fmi2Status status, fmi2String category,
    fmi2String message, ...)
{
    (void)environment, (void)name, (void)category;
    fprintf(stderr, "%d: %s\n", (int)status, message);
}

static void fail(const char *what, const char *why)
{
    fprintf(stderr, "%s %s\n", what, why);
    exit(1);
}

/* ISO C has no conversion from a data pointer to a function pointer; POSIX asks for this one. */
static void find(void *library, const char *name, void *function)
{
    *(void **)function = dlsym(library, name);
    if (*(void **)function == NULL) {
        fail(name, "is missing");
    }
}

static void fmu_open(const char *path)
{
    void *library = dlopen(path, RTLD_NOW);
    if (library == NULL) {
        fail(path, "cannot be opened");
    }
    find(library, "fmi2Instantiate", &fmu.instantiate);
    find(library, "fmi2EnterInitializationMode", &fmu.begin);
    find(library, "fmi2ExitInitializationMode", &fmu.start);
    find(library, "fmi2SetReal", &fmu.set);
    find(library, "fmi2GetReal", &fmu.get);
    find(library, "fmi2DoStep", &fmu.step);
    find(library, "fmi2FreeInstance", &fmu.release);
}

static fmi2Component fmu_started(const char *guid)
{
    static const fmi2CallbackFunctions host = {logger, NULL, NULL, NULL, NULL};
    fmi2Component c = fmu.instantiate("host", fmi2CoSimulation, guid, "", &host, 0, 1);
    if (c == NULL || fmu.begin(c) != fmi2OK || fmu.start(c) != fmi2OK) {
        fail("the FMU", "does not start");
    }
    return c;
}

static double clock_ns(clockid_t clock)
{
    struct timespec now;
    clock_gettime(clock, &now);
    return 1e9 * (double)now.tv_sec + (double)now.tv_nsec;
}

#endif
