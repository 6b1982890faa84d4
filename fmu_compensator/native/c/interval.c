#include "interval.h"

#include <math.h>

#include "constants.h"

/* Returns how far a length is from the shortest tool to the longest, 0 to 1; NaN counts as 0. */
static double share_of(const struct interval *interval, double length)
{
    double low = interval->tool_length_mm[0], high = interval->tool_length_mm[1];
    double share = low < high ? (length - low) / (high - low) : 0.0;
    if (!(share > 0.0)) {
        return 0.0;
    }
    return share > 1.0 ? 1.0 : share;
}

void half_width(
    const struct interval *interval, double since_start_s, double tool_length_mm, double width[3])
{
    double share = share_of(interval, tool_length_mm);
    double age_h = since_start_s / 3600.0;
    age_h = interval->longest_h < age_h ? interval->longest_h : age_h;
    double grown = pow(interval->fresh_h + age_h, interval->power);
    for (int axis = 0; axis < 3; axis++) {
        double shortest = interval->shortest_um[axis], longest = interval->longest_um[axis];
        double scale = shortest + share * (longest - shortest);
        width[axis] = isnan(scale) ? INTERVAL_NOT_KNOWN : scale * grown;
    }
}
