/* A model without an array: an array of one variable is none. */
#include "model.h"

const struct array model_array = {0, 1};
