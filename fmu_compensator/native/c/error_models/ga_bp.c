/* Back-propagation network whose size and start a genetic algorithm chose: it runs as any does. */
#include "network.h"

const struct error_model_kind ga_bp_kind = {"ga_bp", network_make, NULL, network_predict};
