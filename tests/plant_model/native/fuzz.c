/* Calls the FMI functions of one FMU in random order with random arguments, sound ones and bad ones.

   fuzz SEED CALLS: prints how many calls were OK, discarded and refused. Compiled with the FMU's
   sources and sanitizers, which end it at the first fault. */
#include <math.h>
#include <stdbool.h>
#include <stdio.h>
#include <stdlib.h>

#include "fmi2Functions.h"
#include "model.h"

static unsigned long long state;

static unsigned draw(unsigned count)
{
    state = state * 6364136223846793005ull + 1442695040888963407ull;
    return (unsigned)((state >> 33) % count);
}

static double number(void)
{
    static const double odd[] = {0.0, -0.0, 1.0, -1.0, 20.0, 1e300, -1e300, 1e-300, 1e6};
    switch (draw(8)) {
    case 0:
        return NAN;
    case 1:
        return draw(2) ? INFINITY : -INFINITY;
    case 2:
        return odd[draw(sizeof odd / sizeof odd[0])];
    default:
        return draw(20000);
    }
}

static void logger(
    fmi2ComponentEnvironment environment, fmi2String name, fmi2Status status, fmi2String category,
    fmi2String form, ...)
{
    (void)environment, (void)name, (void)status, (void)category, (void)form;
}

static const fmi2CallbackFunctions host = {logger, NULL, NULL, NULL, NULL};
static fmi2FMUstate kept;
static double now;

static fmi2Status values(fmi2Component c)
{
    fmi2ValueReference refs[3];
    double reals[3];
    int whole[3] = {(int)draw(1000), -1, 7};
    for (int i = 0; i < 3; i++) {
        refs[i] = draw((unsigned)model_variable_count + 2);
        reals[i] = number();
    }
    switch (draw(6)) {
    case 0:
        return fmi2GetReal(c, refs, draw(4), draw(30) ? reals : NULL);
    case 1:
        return fmi2GetInteger(c, refs, draw(4), whole);
    case 2:
        return fmi2SetInteger(c, refs, draw(4), whole);
    case 3: {
        /* Mostly inputs that can be, so that steps are made. */
        double sound[] = {(double)draw(12000), 15.0 + draw(10), 15.0 + draw(10)};
        fmi2ValueReference first[] = {0, 1, 2};
        return fmi2SetReal(c, first, 3, sound);
    }
    default:
        return fmi2SetReal(c, refs, draw(10) ? 0 : 3, reals);
    }
}

static fmi2Status states(fmi2Component c)
{
    size_t size = 0;
    fmi2Status status = fmi2OK;
    switch (draw(4)) {
    case 0:
        return fmi2GetFMUstate(c, &kept);
    case 1:
        return fmi2SetFMUstate(c, kept);
    case 2:
        return fmi2FreeFMUstate(c, &kept);
    default:
        if (kept == NULL || fmi2SerializedFMUstateSize(c, kept, &size) != fmi2OK) {
            return fmi2Error;
        }
        fmi2Byte *bytes = malloc(size);
        fmi2FMUstate other = NULL;
        fmi2SerializeFMUstate(c, kept, bytes, size);
        if (draw(2)) {
            bytes[draw((unsigned)size)] ^= 1;
        }
        status = fmi2DeSerializeFMUstate(c, bytes, draw(20) ? size : size / 2, &other);
        if (status == fmi2OK) {
            fmi2SetFMUstate(c, other);
        }
        fmi2FreeFMUstate(c, &other);
        free(bytes);
        return status;
    }
}

static fmi2Component instance(void)
{
    bool exchange = model_continuous != NULL && draw(2);
    fmi2Type type = exchange ? fmi2ModelExchange : fmi2CoSimulation;
    return fmi2Instantiate("fuzz", type, model_guid, "", &host, 0, 1);
}

static fmi2Status exchanges(fmi2Component c)
{
    size_t known = model_continuous == NULL ? 0 : model_continuous->count;
    size_t count = draw(5) ? known : draw((unsigned)known + 2);
    double *row = malloc((known + 2) * sizeof *row), *given = draw(20) ? row : NULL;
    fmi2EventInfo info;
    fmi2Boolean event, end;
    fmi2Status status = fmi2Error;
    for (size_t i = 0; i < known + 2; i++) {
        row[i] = draw(100) ? (double)draw(60) : number();
    }
    switch (draw(11)) {
    case 0:
        status = fmi2EnterEventMode(c);
        break;
    case 1:
        status = fmi2NewDiscreteStates(c, &info);
        break;
    case 2:
        status = fmi2EnterContinuousTimeMode(c);
        break;
    case 3:
        status = fmi2CompletedIntegratorStep(c, 0, &event, draw(20) ? &end : NULL);
        break;
    case 4:
        status = fmi2SetTime(c, number());
        break;
    case 5:
        status = fmi2SetContinuousStates(c, given, count);
        break;
    case 6:
        status = fmi2GetContinuousStates(c, given, count);
        break;
    case 7:
        status = fmi2GetNominalsOfContinuousStates(c, given, count);
        break;
    case 8:
        status = fmi2GetEventIndicators(c, given, count);
        break;
    case 9: {
        unsigned all = (unsigned)model_variable_count + 2;
        fmi2ValueReference unknown[] = {draw(all), all - 3}, known[] = {draw(8), draw(all)};
        double change[2];
        unsigned one = 1 + (draw(4) == 0);
        status = fmi2GetDirectionalDerivative(c, unknown + 2 - one, one, known, one, given, change);
        break;
    }
    default:
        status = fmi2GetDerivatives(c, given, count);
    }
    free(row);
    return status;
}

static fmi2Status call(fmi2Component *c)
{
    /* A step of hours goes on in many parts, so few are. */
    double odd = draw(40) ? -(double)draw(3) : number(), step = draw(10) ? 1.0 + draw(30) : odd;
    fmi2Status status = fmi2OK;
    switch (draw(60)) {
    case 0:
        return fmi2Reset(*c);
    case 1:
        return fmi2Terminate(*c);
    case 2:
        now = 0.0;
        return fmi2SetupExperiment(*c, 0, 0.0, draw(5) ? 0.0 : number(), draw(4) == 0, 1e5);
    case 3:
    case 4:
    case 5:
        return fmi2EnterInitializationMode(*c);
    case 6:
    case 7:
    case 8:
        return fmi2ExitInitializationMode(*c);
    case 9:
        fmi2FreeInstance(*c);
        *c = instance();
        return fmi2OK;
    case 10:
        return fmi2DoStep(draw(2) ? *c : NULL, number(), step, fmi2True);
    case 11:
        return fmi2Instantiate(NULL, draw(2), "no", NULL, &host, 0, 1) == NULL ? fmi2Error : fmi2OK;
    default:
        break;
    }
    if (draw(3) == 0) {
        return values(*c);
    }
    if (draw(6) == 0) {
        return states(*c);
    }
    if (model_derivatives != NULL && draw(2)) {
        return exchanges(*c);
    }
    fmi2GetRealStatus(*c, fmi2LastSuccessfulTime, &now);
    status = fmi2DoStep(*c, now, step, fmi2True);
    return status;
}

int main(int count, char **arguments)
{
    long calls = count == 3 ? atol(arguments[2]) : 0, seen[3] = {0, 0, 0};
    state = count == 3 ? (unsigned long long)atol(arguments[1]) : 0;
    fmi2Component c = instance();
    for (long k = 0; k < calls; k++) {
        fmi2Status status = call(&c);
        seen[status == fmi2OK ? 0 : status == fmi2Discard ? 1 : 2]++;
    }
    fmi2FreeFMUstate(c, &kept);
    fmi2FreeInstance(c);
    printf("%ld %ld %ld\n", seen[0], seen[1], seen[2]);
    return 0;
}
