#ifndef SLIPMODE_SEGMENT_H
#define SLIPMODE_SEGMENT_H

#include "base/cnumber.h"
#include "slipmode.h"

/* exp(i theta_j) of two carriers at `elapsed` seconds into the segment; 1 for a mode it has not. */
void sm_segment_carriers(const sm_segment *segment, int modes, double elapsed,
                         sm_complex carrier[SM_MODES]);
/* a_j at the fraction r of the segment, by cubic Hermite interpolation. */
sm_complex sm_segment_amplitude(const sm_segment *segment, int mode, double r);
/* The same as cubics c[0] + r (c[1] + r (c[2] + r c[3])): its real and its imaginary part. */
void sm_segment_cubics(const sm_segment *segment, int mode, double cubics[2][4]);
double sm_segment_end(const sm_segment *segment);

/* Finite, and each segment starts where the last one ends. */
sm_status sm_segments_check(size_t segments, const sm_segment *segment, int modes);
/* Finite, increasing, inside the segments. */
sm_status sm_times_check(size_t samples, const double *times, size_t segments,
                         const sm_segment *segment);

#endif
