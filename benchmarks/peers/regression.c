/* The regression as a C programmer writes an FMU by hand, FMI 2.0: no checks, one instance's numbers
   in one block. */

#include <stdlib.h>

#include "fmi2Functions.h"

enum { INPUTS = 11, OUTPUTS = 3 };

typedef struct {
    fmi2Real values[INPUTS + OUTPUTS];
} Regression;

const char *fmi2GetTypesPlatform(void) { return fmi2TypesPlatform; }
const char *fmi2GetVersion(void) { return fmi2Version; }

fmi2Component fmi2Instantiate(fmi2String name, fmi2Type type, fmi2String guid, fmi2String place,
                              const fmi2CallbackFunctions *functions, fmi2Boolean visible,
                              fmi2Boolean logging) {
    (void)name, (void)type, (void)guid, (void)place, (void)functions, (void)visible, (void)logging;
    return calloc(1, sizeof(Regression));
}

void fmi2FreeInstance(fmi2Component c) { free(c); }

fmi2Status fmi2GetReal(fmi2Component c, const fmi2ValueReference refs[], size_t count,
                       fmi2Real values[]) {
    for (size_t i = 0; i < count; i++)
        values[i] = ((Regression *)c)->values[refs[i]];
    return fmi2OK;
}

fmi2Status fmi2SetReal(fmi2Component c, const fmi2ValueReference refs[], size_t count,
                       const fmi2Real values[]) {
    for (size_t i = 0; i < count; i++)
        ((Regression *)c)->values[refs[i]] = values[i];
    return fmi2OK;
}

fmi2Status fmi2DoStep(fmi2Component c, fmi2Real time, fmi2Real step, fmi2Boolean no_set) {
    (void)time, (void)step, (void)no_set;
    fmi2Real *values = ((Regression *)c)->values;
    for (int k = 0; k < OUTPUTS; k++) {
        values[INPUTS + k] = 0.0;
        for (int i = 0; i < INPUTS; i++)
            values[INPUTS + k] += (0.1 * (k + 1) + 0.01 * i) * values[i];
    }
    return fmi2OK;
}

fmi2Status fmi2SetupExperiment(fmi2Component c, fmi2Boolean has_tolerance, fmi2Real tolerance,
                               fmi2Real start, fmi2Boolean has_stop, fmi2Real stop) {
    (void)c, (void)has_tolerance, (void)tolerance, (void)start, (void)has_stop, (void)stop;
    return fmi2OK;
}

fmi2Status fmi2EnterInitializationMode(fmi2Component c) { return c ? fmi2OK : fmi2Error; }
fmi2Status fmi2ExitInitializationMode(fmi2Component c) { return c ? fmi2OK : fmi2Error; }
fmi2Status fmi2Terminate(fmi2Component c) { return c ? fmi2OK : fmi2Error; }
fmi2Status fmi2Reset(fmi2Component c) { return c ? fmi2OK : fmi2Error; }
