/* A model without an array: one variable is none. */
#include "model.h"

const struct array model_array = {0, 1};
