/* A segment of slow time with linear inputs: its carriers and amplitudes. */
#ifndef SLIPMODE_SEGMENT_H
#define SLIPMODE_SEGMENT_H

#include "base/cnumber.h"
#include "slipmode.h"

/* Computes exp(i theta_j) `elapsed` seconds after the start; 1 for a mode that does not exist. */
void sm_segment_carriers(const sm_segment *segment, int modes, double elapsed,
                         sm_complex carrier[SM_MODES]);
/* Returns a_j at the fraction r of the segment, and its rate of change, by cubic Hermite
 * interpolation. */
sm_complex sm_segment_amplitude(const sm_segment *segment, int mode, double r, sm_complex *rate);
/* Returns the time at the end of the segment [s]. */
double sm_segment_end(const sm_segment *segment);

/* Checks that the segments are finite, and that each one starts where the one before ends. */
sm_status sm_segments_check(size_t segments, const sm_segment *segment, int modes);
/* Checks that the times are finite, increasing and inside the segments. */
sm_status sm_times_check(size_t samples, const double *times, size_t segments,
                         const sm_segment *segment);

#endif
