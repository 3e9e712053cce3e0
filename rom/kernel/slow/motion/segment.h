/* A segment of slow time with linear inputs: its carriers and amplitudes. */
#ifndef SLIPMODE_SEGMENT_H
#define SLIPMODE_SEGMENT_H

#include "base/cnumber.h"
#include "slipmode.h"

/* Computes exp(i theta_j) `elapsed` seconds after the start; 1 for a mode that does not exist. */
void sm_segment_carriers(const sm_segment *segment, int modes, double elapsed,
                         sm_complex carrier[SM_MODES]);
/* Returns a_j at the fraction r of the segment, by cubic Hermite interpolation. */
sm_complex sm_segment_amplitude(const sm_segment *segment, int mode, double r);
/* Computes the cubics c[0] + r (c[1] + r (c[2] + r c[3])) of the real and the imaginary part of
 * a_j. */
void sm_segment_cubics(const sm_segment *segment, int mode, double cubics[2][4]);
/* Returns the time at the end of the segment [s]. */
double sm_segment_end(const sm_segment *segment);

/* Checks that the segments are finite, and that each one starts where the one before ends. */
sm_status sm_segments_check(size_t segments, const sm_segment *segment, int modes);
/* Checks that the times are finite, increasing and inside the segments. */
sm_status sm_times_check(size_t samples, const double *times, size_t segments,
                         const sm_segment *segment);

#endif
