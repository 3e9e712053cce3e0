/* A segment of slow time with linear inputs: its carriers and amplitudes. Amplitudes are cubic
 * Hermite polynomials in time, angles theta_j are quadratic. The contact motion (contact_march.c)
 * and the sum of harmonics (harmonic_sum.c) evaluate segments from Python or from the queue of a
 * component.
 */
#include "slow/motion/segment.h"

#include <math.h>

#include "base/check.h"
#include "base/hermite.h"

void sm_segment_carriers(const sm_segment *g, int modes, double elapsed,
                         sm_complex carrier[SM_MODES]) {
    for (int j = 0; j < SM_MODES; j++) {
        const double angle =
            g->angle[j] + elapsed * (g->frequency[j] + 0.5 * g->frequency_rate[j] * elapsed);
        carrier[j] = j < modes ? sm_unit(angle) : sm_cx(1.0, 0.0);
    }
}

sm_complex sm_segment_amplitude(const sm_segment *g, int j, double r, sm_complex *rate) {
    const sm_hermite at = sm_hermite_at(g->duration, r);
    double a[2], slope[2];
    for (int p = 0; p < 2; p++) {
        const int k = 2 * j + p;
        const double start = g->amplitude_start[k], end = g->amplitude_end[k];
        a[p] = sm_hermite_value(&at.value, start, g->rate_start[k], end, g->rate_end[k]);
        slope[p] = sm_hermite_slope(&at.slope, start, g->rate_start[k], end, g->rate_end[k]);
    }
    *rate = sm_pair(slope);
    return sm_pair(a);
}

double sm_segment_end(const sm_segment *g) { return g->start + g->duration; }

/* Tolerance of the times at which segments meet, relative to the duration of the segment [-]. */
#define MEETING_TOLERANCE 1e-6

/* Checks the numbers of a segment. */
static sm_status check_segment(const sm_segment *segment, int modes) {
    if (!isfinite(segment->start)) return SM_NOT_FINITE;
    const size_t count = (size_t)modes, pairs = 2 * (size_t)modes;
    if (!sm_all_finite(segment->amplitude_start, pairs) ||
        !sm_all_finite(segment->amplitude_end, pairs) ||
        !sm_all_finite(segment->rate_start, pairs) || !sm_all_finite(segment->rate_end, pairs) ||
        !sm_all_finite(segment->angle, count) || !sm_all_finite(segment->frequency, count) ||
        !sm_all_finite(segment->frequency_rate, count))
        return SM_NOT_FINITE;
    return sm_check_positive(segment->duration);
}

/* Returns whether a segment starts where the one before ends, to rounding. */
static int consecutive(const sm_segment *segment, const sm_segment *next) {
    const double gap = fabs(next->start - sm_segment_end(segment));
    return next->start > segment->start &&
           gap <= MEETING_TOLERANCE * segment->duration
                      + SM_ROUNDING_TOLERANCE * fabs(segment->start);
}

sm_status sm_segments_check(size_t segments, const sm_segment *segment, int modes) {
    if (segments < 1 || !segment) return SM_BAD_ARGUMENT;
    for (size_t k = 0; k < segments; k++) {
        SM_TRY(check_segment(&segment[k], modes));
        if (k > 0 && !consecutive(&segment[k - 1], &segment[k])) return SM_BAD_ARGUMENT;
    }
    return SM_OK;
}

sm_status sm_times_check(size_t samples, const double *times, size_t segments,
                         const sm_segment *segment) {
    if (samples == 0) return SM_OK;
    if (!times) return SM_BAD_ARGUMENT;
    if (!sm_all_finite(times, samples)) return SM_NOT_FINITE;
    const sm_segment *last = &segment[segments - 1];
    const double end = sm_segment_end(last) + SM_ROUNDING_TOLERANCE * last->duration;
    if (!(times[0] >= segment->start && times[samples - 1] <= end)) return SM_BAD_ARGUMENT;
    for (size_t k = 1; k < samples; k++)
        if (!(times[k] > times[k - 1])) return SM_BAD_ARGUMENT;
    return SM_OK;
}
