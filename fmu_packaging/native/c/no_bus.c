/* A model without a bus terminal. */
#include "bus.h"

const struct bus *const model_bus = NULL;
