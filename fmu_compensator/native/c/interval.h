/* How far the drift of the tool tip may be from the predicted one. */
#ifndef INTERVAL_H
#define INTERVAL_H

/* See the Python twin; NaN stands for an axis along which nothing was measured. */
struct interval {
    double coverage, power, fresh_h, longest_h;
    double shortest_um[3], longest_um[3]; /* at the shortest and the longest tool */
    double tool_length_mm[2];
};

/* Puts down half the width for X, Y and Z [um]: s(L) (t0 + t)^p. */
void half_width(
    const struct interval *interval, double since_start_s, double tool_length_mm, double width[3]);

#endif
