#include "interval.h"

#include <math.h>

#include "constants.h"

double interval_growth(const struct interval *interval, double since_start_s, double novelty)
{
    double age_h = since_start_s / 3600.0;
    age_h = interval->longest_h < age_h ? interval->longest_h : age_h;
    double grown = pow(interval->fresh_h + age_h, interval->power);
    return grown * sqrt(1.0 + interval->per_novelty * novelty);
}

void half_width(
    const struct interval *interval, double growth, double tool_share, double width[3])
{
    for (int axis = 0; axis < 3; axis++) {
        double shortest = interval->shortest_um[axis], longest = interval->longest_um[axis];
        double scale = shortest + tool_share * (longest - shortest);
        width[axis] = isnan(scale) ? INTERVAL_NOT_KNOWN : scale * growth;
    }
}
