/* Steps an FMU whose sources it is linked with, and prints its outputs; then whether a second
   instance can be had beside the first, whether a state can, and whether another instance can be
   had when the first has gone. */
#include <stdio.h>

#include "fmi2Functions.h"
#include "model.h"

static fmi2Component started(const char *name)
{
    static const fmi2CallbackFunctions host = {NULL, NULL, NULL, NULL, NULL};
    fmi2Component c = fmi2Instantiate(name, fmi2CoSimulation, model_guid, "", &host, 0, 0);
    if (c != NULL && (fmi2EnterInitializationMode(c) || fmi2ExitInitializationMode(c))) {
        return NULL;
    }
    return c;
}

static void step(fmi2Component c, int k)
{
    for (fmi2ValueReference ref = 0; ref < model_variable_count; ref++) {
        const struct variable *variable = &model_variables[ref];
        double value = variable->start != 0.0 ? variable->start : 20.0 + 0.01 * k * (ref + 1);
        if (variable->causality == INPUT && variable->kind == REAL) {
            fmi2SetReal(c, &ref, 1, &value);
        }
    }
    printf("%d", (int)fmi2DoStep(c, k, 1.0, 1));
    for (fmi2ValueReference ref = 0; ref < model_variable_count; ref++) {
        double value = 0.0;
        if (model_variables[ref].causality == OUTPUT && model_variables[ref].kind == REAL) {
            fmi2GetReal(c, &ref, 1, &value);
            printf(" %a", value);
        }
    }
    printf("\n");
}

int main(void)
{
    fmi2FMUstate state = NULL;
    fmi2Component c = started("one"), second = NULL;
    for (int k = 0; c != NULL && k < 200; k++) {
        step(c, k);
    }
    second = started("another");
    int states = c != NULL && fmi2GetFMUstate(c, &state) == fmi2OK;
    fmi2FreeFMUstate(c, &state);
    fmi2FreeInstance(c);
    fmi2FreeInstance(second);
    c = started("an instance of another name");
    printf("%d %d %d\n", second != NULL, states, c != NULL);
    fmi2FreeInstance(c);
    return 0;
}
