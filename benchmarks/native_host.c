/* The smallest host: sets the inputs, steps, gets the outputs, and prints what a step took [ns].

   native_host LIBRARY GUID STEPS INPUTS TOOL FIRST OUTPUTS: the inputs are the value references from
   0 on, TOOL is that of the tool length, the outputs are those from FIRST on. All other inputs start
   at 20 and rise, each a little faster. */
#include "fmu_host.h"

int main(int count, char **arguments)
{
    static fmi2ValueReference in_refs[MOST], out_refs[MOST];
    static double in[MOST], out[MOST];
    if (count != 8) {
        fail("usage:", "native_host LIBRARY GUID STEPS INPUTS TOOL FIRST OUTPUTS");
    }
    long steps = atol(arguments[3]);
    size_t inputs = (size_t)atol(arguments[4]), tool = (size_t)atol(arguments[5]);
    size_t first = (size_t)atol(arguments[6]), outputs = (size_t)atol(arguments[7]);
    if (inputs > MOST || outputs > MOST || tool >= inputs) {
        fail("the FMU", "has too many variables");
    }
    fmu_open(arguments[1]);
    fmi2Component c = fmu_started(arguments[2]);
    for (size_t i = 0; i < MOST; i++) {
        in_refs[i] = (fmi2ValueReference)i;
        out_refs[i] = (fmi2ValueReference)(first + i);
    }
    int status = 0;
    double before = clock_ns(CLOCK_MONOTONIC);
    for (long k = 0; k < steps; k++) {
        for (size_t i = 0; i < inputs; i++) {
            in[i] = 20.0 + 1e-6 * (double)(i + 1) * (double)k;
        }
        in[tool] = 100.0;
        status |= (int)fmu.set(c, in_refs, inputs, in);
        status |= (int)fmu.step(c, (double)k, 1.0, 1);
        status |= (int)fmu.get(c, out_refs, outputs, out);
    }
    printf("%.3f %d\n", (clock_ns(CLOCK_MONOTONIC) - before) / (double)steps, status);
    fmu.release(c);
    return status;
}
