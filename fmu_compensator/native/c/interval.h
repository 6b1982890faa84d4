/* How far the drift of the tool tip may be from the predicted one. */
#ifndef INTERVAL_H
#define INTERVAL_H

/* See the Python twin; NaN stands for an axis along which nothing was measured. */
struct interval {
    double coverage, power, fresh_h, longest_h, per_novelty;
    double shortest_um[3], longest_um[3]; /* at the shortest and the longest tool */
};

/* Returns the width over its scale, before any measurement [h^p]: (t0 + t)^p sqrt(1 + k h). */
double interval_growth(const struct interval *interval, double since_start_s, double novelty);

/* Puts down half the width for X, Y and Z [um]. Growth is the above, times the root of the doubt
   that is left; tool_share says where the tool is from the shortest (0) to the longest (1). */
void half_width(
    const struct interval *interval, double growth, double tool_share, double width[3]);

#endif
