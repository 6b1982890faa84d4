/* Prints the memory that an instance and a state take without a heap [bytes]. */
#include <stdio.h>

#include "memory.h"
#include "model.h"

#ifdef MEASURE_FMI3
#include "fmi3Functions.h"

static fmi3Instance new_instance(void)
{
    return fmi3InstantiateCoSimulation(
        "", model_guid, "", 0, 0, 0, 0, NULL, 0, NULL, NULL, NULL);
}

static int take_state(fmi3Instance c)
{
    fmi3FMUState state = NULL;
    return fmi3GetFMUState(c, &state) == fmi3OK;
}
#else
#include "fmi2Functions.h"

static fmi2Component new_instance(void)
{
    static const fmi2CallbackFunctions host = {NULL, NULL, NULL, NULL, NULL};
    return fmi2Instantiate("", fmi2CoSimulation, model_guid, "", &host, 0, 0);
}

static int take_state(fmi2Component c)
{
    fmi2FMUstate state = NULL;
    return fmi2GetFMUstate(c, &state) == fmi2OK;
}
#endif

int main(void)
{
    void *c = new_instance();
    size_t instance = memory_most();
    if (c == NULL || !take_state(c)) {
        return 1;
    }
    printf("%zu %zu\n", instance, memory_most() - instance);
    return 0;
}
