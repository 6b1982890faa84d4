/* What each step of a plant costs by itself [ns]: the least of many runs of the same steps, each by an
   instance of its own, so that what else the machine does counts for nothing.

   plant_steps LIBRARY GUID RUNS INPUTS STEP_S SPEED...: one step at each speed, the first input; the
   others keep their start values. Prints a line for each step, and one for a step among as many more
   at the last speed that are timed together: a clock cannot tell what a step that does nothing takes. */
#include "fmu_host.h"

#include <math.h>

int main(int count, char **arguments)
{
    static fmi2ValueReference refs[MOST];
    static double in[MOST], least[MOST];
    if (count < 7 || count - 6 > MOST) {
        fail("usage:", "plant_steps LIBRARY GUID RUNS INPUTS STEP_S SPEED...");
    }
    int runs = atoi(arguments[3]), steps = count - 6;
    size_t inputs = (size_t)atol(arguments[4]);
    double step_s = atof(arguments[5]), idle = INFINITY, together = INFINITY;
    if (inputs > MOST) {
        fail("the FMU", "has too many variables");
    }
    fmu_open(arguments[1]);
    for (size_t i = 0; i < MOST; i++) {
        refs[i] = (fmi2ValueReference)i;
        least[i] = INFINITY;
    }
    for (int run = 0; run < runs; run++) {
        fmi2Component c = fmu_started(arguments[2]);
        int status = (int)fmu.get(c, refs, inputs, in);
        for (int k = 0; k < steps; k++) {
            in[0] = atof(arguments[6 + k]);
            status |= (int)fmu.set(c, refs, inputs, in);
            double clock = clock_ns(CLOCK_MONOTONIC), before = clock_ns(CLOCK_MONOTONIC);
            status |= (int)fmu.step(c, (double)k * step_s, step_s, 1);
            double after = clock_ns(CLOCK_MONOTONIC);
            idle = fmin(idle, before - clock);
            least[k] = fmin(least[k], after - before);
        }
        double begun = clock_ns(CLOCK_MONOTONIC);
        for (int k = steps; k < 2 * steps; k++) {
            status |= (int)fmu.step(c, (double)k * step_s, step_s, 1);
        }
        together = fmin(together, clock_ns(CLOCK_MONOTONIC) - begun);
        fmu.release(c);
        if (status != 0) {
            fail("a call", "was refused");
        }
    }
    for (int k = 0; k < steps; k++) {
        printf("%.1f\n", least[k] - idle);
    }
    printf("%.2f\n", (together - idle) / steps);
    return 0;
}
