/* Contact motion at given times along a slow trajectory, eq. (12). The contacts are integrated
 * (contact_march.c) over segments of slow motion. Their initial state decays within a few
 * periods, so that segments need to start only a few periods before the first sample.
 * rom/slow/motion.py and rom/cyclic call it. */
#include <stdlib.h>

#include "base/check.h"
#include "slow/motion/contact_march.h"
#include "slow/motion/segment.h"

sm_status sm_contact_motion(const sm_contact *contact, size_t segments, const sm_segment *segment,
                            const double *start_x, int32_t steps_per_period,
                            const sm_contact_samples *samples) {
    if (!samples) return SM_BAD_ARGUMENT;
    SM_TRY(sm_contact_check(contact));
    if (contact->contacts == 0) return SM_BAD_ARGUMENT;
    SM_TRY(sm_segments_check(segments, segment, contact->modes));
    SM_TRY(sm_times_check(samples->count, samples->times, segments, segment));
    const size_t n = (size_t)contact->contacts, bytes = n * sizeof(double);
    const double *times = samples->times;
    if (steps_per_period < SM_MIN_STEPS || steps_per_period > SM_MOST
        || !sm_fits(samples->count, bytes))
        return SM_BAD_ARGUMENT;
    if (start_x && !sm_all_finite(start_x, n)) return SM_NOT_FINITE;
    const int orders = contact->response ? contact->response->orders_count : 0;
    sm_block block = {NULL, 0};
    sm_march march;
    sm_take(&block, sm_march_state_count(contact));
    sm_march_place(&march, contact, orders, &block);
    if (!sm_allocate(&block)) return SM_NO_MEMORY;
    double *state = sm_take(&block, sm_march_state_count(contact));
    sm_march_place(&march, contact, orders, &block);
    if (start_x) memcpy(state, start_x, bytes);
    sm_march_start(&march, contact, state);
    sm_status status = SM_OK;
    size_t g = 0;
    double now = segment[0].start;
    for (size_t k = 0; k < samples->count && status == SM_OK; k++) {
        while (now < times[k] && status == SM_OK) {
            const double end = sm_segment_end(&segment[g]);
            if (now >= end && g + 1 < segments) {
                g++;
                continue;
            }
            /* the velocity after a very short step, from the segment's end to the sample, would
             * have no correct digits */
            const double past = times[k] - end;
            const double rounding = SM_ROUNDING_TOLERANCE * segment[g].duration;
            const double to = past < rounding || g + 1 == segments ? times[k] : end;
            const sm_detail detail = to == times[k] ? SM_TO_BE_READ : SM_RESOLVED;
            status = sm_march_along(&march, contact, &segment[g], now - segment[g].start,
                                    to - segment[g].start, steps_per_period, detail);
            now = to;
        }
        if (samples->displacement) memcpy(samples->displacement + k * n, march.x, bytes);
        if (samples->velocity) memcpy(samples->velocity + k * n, march.v, bytes);
        if (samples->force) memcpy(samples->force + k * n, march.force, bytes);
    }
    free(block.memory);
    return status;
}
