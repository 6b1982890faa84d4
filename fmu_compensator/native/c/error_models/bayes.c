/* Bayesian ridge regression on temperatures and their lags: it runs as thermal states do. */
#include "thermal_states.h"

const struct error_model_kind bayes_kind = {
    "bayes", thermal_states_make, NULL, thermal_states_predict};
