/* The smallest host of a plant: sets the inputs, steps, gets the outputs, and prints what a step
   took [ns].

   plant_host LIBRARY GUID STEPS INPUTS FIRST OUTPUTS SPEED...: the inputs are the value references
   from 0 on and keep their values but for the first, the speed, which goes through the values given,
   over and over, plus a millionth of the step's number where there are several; the outputs are
   those from FIRST on. */
#include "fmu_host.h"

int main(int count, char **arguments)
{
    static fmi2ValueReference in_refs[MOST], out_refs[MOST];
    static double in[MOST], out[MOST];
    if (count < 8) {
        fail("usage:", "plant_host LIBRARY GUID STEPS INPUTS FIRST OUTPUTS SPEED...");
    }
    long steps = atol(arguments[3]), speeds = count - 7;
    size_t inputs = (size_t)atol(arguments[4]), outputs = (size_t)atol(arguments[6]);
    if (inputs > MOST || outputs > MOST) {
        fail("the FMU", "has too many variables");
    }
    fmu_open(arguments[1]);
    fmi2Component c = fmu_started(arguments[2]);
    for (size_t i = 0; i < MOST; i++) {
        in_refs[i] = (fmi2ValueReference)i;
        out_refs[i] = (fmi2ValueReference)((size_t)atol(arguments[5]) + i);
    }
    int status = (int)fmu.get(c, in_refs, inputs, in);
    double before = clock_ns(CLOCK_PROCESS_CPUTIME_ID);
    for (long k = 0; k < steps; k++) {
        in[0] = atof(arguments[7 + k % speeds]) + (speeds > 1 ? 1e-6 * (double)k : 0.0);
        status |= (int)fmu.set(c, in_refs, inputs, in);
        status |= (int)fmu.step(c, (double)k, 1.0, 1);
        status |= (int)fmu.get(c, out_refs, outputs, out);
    }
    double taken = clock_ns(CLOCK_PROCESS_CPUTIME_ID) - before;
    printf("%.17g %.17g\n", taken / (double)steps, out[outputs - 1]);
    fmu.release(c);
    return status == 0 ? 0 : 1;
}
