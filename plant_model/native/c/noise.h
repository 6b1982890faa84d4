/* Random numbers of the sensors' noise; see the Python twin, plant_model/noise.py. */
#ifndef NOISE_H
#define NOISE_H

#include <stdint.h>

/* Returns number `place` of a normally distributed sequence. */
double noise_normal(uint32_t seed, double place);

#endif
