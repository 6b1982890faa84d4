#include "noise.h"

#include <math.h>

#define GAMMA UINT64_C(0x9E3779B97F4A7C15)
#define TWO_PI 6.283185307179586476925286766559

/* SplitMix64 (Steele, Lea and Flood 2014, doi:10.1145/2714064.2660195). */
static uint64_t mixed(uint64_t z)
{
    z = (z ^ (z >> 30)) * UINT64_C(0xBF58476D1CE4E5B9);
    z = (z ^ (z >> 27)) * UINT64_C(0x94D049BB133111EB);
    return z ^ (z >> 31);
}

static double even(uint64_t begin, uint64_t place)
{
    return (double)(mixed(begin + place * GAMMA) >> 11) * 0x1p-53;
}

double noise_normal(uint32_t seed, double place)
{
    uint64_t begin = mixed(seed * GAMMA), pair = 2 * (uint64_t)place;
    double radius = sqrt(-2.0 * log(1.0 - even(begin, pair + 1)));
    return radius * cos(TWO_PI * even(begin, pair + 2));
}
