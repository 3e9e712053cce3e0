#ifndef SLIPMODE_SEGMENT_H
#define SLIPMODE_SEGMENT_H

#include "base/harmonics.h"
#include "slipmode.h"

/* exp(i theta_j) of two carriers at `elapsed` seconds into the segment; 1 for a mode it has not. */
void sm_segment_carriers(const sm_segment *segment, int modes, double elapsed,
                         sm_complex carrier[SM_MODES]);
/* The same at equal intervals of time by recurrence: a step is a factor `by`, which moves in a
 * sweep. Rounding grows with the count, so start anew every SM_ROTOR_STEPS. */
#define SM_ROTOR_STEPS 64
typedef struct {
    sm_complex carrier[SM_MODES], by[SM_MODES], bend[SM_MODES];
} sm_rotor;

void sm_rotor_start(sm_rotor *rotor, const sm_segment *segment, int modes, double elapsed,
                    double interval);

static inline void sm_rotor_advance(sm_rotor *rotor, int modes) {
    for (int j = 0; j < modes; j++) {
        rotor->carrier[j] = sm_cmul(rotor->carrier[j], rotor->by[j]);
        rotor->by[j] = sm_cmul(rotor->by[j], rotor->bend[j]);
    }
}

/* a_j at the fraction r of the segment, by cubic Hermite interpolation. */
sm_complex sm_segment_amplitude(const sm_segment *segment, int mode, double r);
double sm_segment_end(const sm_segment *segment);

/* Finite, and each segment starts where the last one ends. */
sm_status sm_segments_check(size_t segments, const sm_segment *segment, int modes);
/* Finite, increasing, inside the segments. */
sm_status sm_times_check(size_t samples, const double *times, size_t segments,
                         const sm_segment *segment);

#endif
