/* Contact motion along a slow trajectory: eq. (12) marched with the slowly varying amplitudes.
 *
 * Friction forgets its past within a few periods, so the march may start a few periods before
 * the first time asked for; there is no need to start at t = 0.
 */
#include "slow/motion/contact_motion.h"

#include <stdlib.h>

#include "base/check.h"
#include "base/exact_sum.h"
#include "slow/motion/segment.h"

#define MAX_STEPS 1e10 /* of one march: hours */
/* Tolerances of v / alpha: S magnifies what it is off by where the force is read. */
#define ON_THE_WAY 1e-7
#define AT_THE_END 1e-10

size_t sm_march_size(int contacts, int orders) {
    return sm_stepper_size(contacts) + sm_lanes_size(contacts, 1) + sm_warm_size(contacts)
           + sm_reaction_size(contacts, orders) + (size_t)contacts;
}

void sm_march_place(sm_march *march, int contacts, int orders, double *memory) {
    sm_stepper_place(&march->stepper, contacts, memory);
    memory += sm_stepper_size(contacts);
    sm_lanes_place(&march->lane, contacts, 1, memory);
    memory += sm_lanes_size(contacts, 1);
    sm_warm_place(&march->warm, contacts, memory);
    memory += sm_warm_size(contacts);
    sm_reaction_place(&march->reaction, contacts, orders, memory);
    march->force = memory + sm_reaction_size(contacts, orders);
}

void sm_march_start(sm_march *march, const double *x, const double *v, const double *f) {
    for (int i = 0; i < march->stepper.contacts; i++) {
        march->lane.x[i] = x ? x[i] : 0.0;
        march->force[i] = f ? f[i] : 0.0;
        march->lane.v[i] = march->lane.stage_v[0][i] = march->lane.stage_v[1][i] = v ? v[i] : 0.0;
    }
}

/* u = -2 Re sum_j L_j a_j exp(i theta_j) at `elapsed` seconds into the segment. */
SM_INLINE void load_forcing(const sm_contact *contact, const sm_segment *g, double elapsed,
                         const sm_complex carrier[SM_MODES], double *u) {
    const int n = contact->contacts;
    const double r = elapsed / g->duration;
    for (int i = 0; i < n; i++) u[i] = 0.0;
    for (int j = 0; j < contact->modes; j++) {
        const sm_complex q = sm_cmul(sm_segment_amplitude(g, j, r), carrier[j]);
        const double *L = contact->coupling + 2 * (size_t)j * (size_t)n;
        for (int i = 0; i < n; i++) u[i] -= 2.0 * (L[2 * i] * q.re - L[2 * i + 1] * q.im);
    }
}

/* The modes' response on top of it, in step k. */
SM_INLINE void load_reaction(sm_reaction *reaction, const sm_contact *contact, const sm_segment *g,
                             int64_t k, int stage, double elapsed, const sm_rotor *rotor,
                             double *u) {
    const int swept = g->frequency_rate[0] != 0.0 || g->frequency_rate[1] != 0.0;
    const int32_t *orders = contact->response->orders;
    if (swept || k % SM_ROTOR_STEPS == 0)
        sm_reaction_set(reaction, stage, orders, rotor->carrier);
    else
        sm_reaction_advance(reaction, stage);
    if (k == 0 && stage == 0) sm_reaction_set_factors(reaction, orders, rotor->by);
    sm_reaction_add(reaction, contact->contacts, stage, elapsed / g->duration, u);
}

/* g = r - S v, where rounding must not carry it beyond the limit. */
static void find_force(sm_march *march) {
    const sm_stepper *s = &march->stepper;
    const int n = s->contacts;
    for (int i = 0; i < n; i++) {
        double g = march->warm.r[i];
        for (int j = 0; j < n; j++) g -= s->matrix[i * n + j] * march->warm.v[j];
        march->force[i] = fmax(-s->laws[i].limit, fmin(g, s->laws[i].limit));
    }
}

SM_HOT_ONE sm_status sm_march_along(sm_march *march, const sm_contact *contact,
                                    const sm_segment *segment, double from, double to,
                                    int steps_per_period) {
    double fastest = 0.0;
    for (int j = 0; j < contact->modes; j++) {
        const double end = segment->frequency[j] + segment->frequency_rate[j] * segment->duration;
        fastest = fmax(fastest, fmax(fabs(segment->frequency[j]), fabs(end)));
    }
    const double count = ceil((to - from) * fastest * steps_per_period / SM_TWO_PI * (1.0 - 1e-9));
    if (!(count <= MAX_STEPS)) return SM_BAD_ARGUMENT;
    const int64_t steps = count < 1.0 ? 1 : (int64_t)count;
    const double h = (to - from) / (double)steps;
    sm_status status = sm_stepper_set(&march->stepper, contact, h);
    if (status != SM_OK) return status;
    sm_lanes_forget(&march->lane, contact->contacts, 1);
    sm_warm_start(&march->stepper, &march->warm, march->lane.v, march->force);
    sm_rotor rotor[2];
    const int reacting = contact->response && segment->reaction_start && segment->reaction_end;
    if (reacting) sm_reaction_start(&march->reaction, contact->contacts, segment);
    for (int64_t k = 0; k < steps; k++) {
        march->warm.tolerance = k + 1 < steps ? ON_THE_WAY : AT_THE_END;
        for (int stage = 0; stage < 2; stage++) {
            const double elapsed = from + h * ((double)k + (stage == 0 ? SM_GAMMA : 1.0));
            if (k % SM_ROTOR_STEPS == 0)
                sm_rotor_start(&rotor[stage], segment, contact->modes, elapsed, h);
            else
                sm_rotor_advance(&rotor[stage], contact->modes);
            load_forcing(contact, segment, elapsed, rotor[stage].carrier, march->lane.u);
            if (reacting)
                load_reaction(&march->reaction, contact, segment, k, stage, elapsed, &rotor[stage],
                          march->lane.u);
            status = sm_stage_one(&march->stepper, &march->warm, &march->lane, stage);
            if (status != SM_OK) return status;
        }
    }
    find_force(march);
    /* a NaN or infinity anywhere on the way is still in the displacement */
    return sm_all_finite(march->lane.x, (size_t)contact->contacts) ? SM_OK : SM_NOT_FINITE;
}

sm_status sm_contact_motion(const sm_contact *contact, size_t segments, const sm_segment *segment,
                            const double *start_x, int32_t steps_per_period, size_t samples,
                            const double *times, double *displacement, double *velocity,
                            double *force) {
    sm_status status = sm_contact_check(contact);
    if (status == SM_OK) status = sm_segments_check(segments, segment, contact->modes);
    if (status == SM_OK) status = sm_times_check(samples, times, segments, segment);
    if (status != SM_OK) return status;
    const size_t n = (size_t)contact->contacts;
    if (steps_per_period < 4 || steps_per_period > 65536 || !sm_fits(samples, n * sizeof(double)))
        return SM_BAD_ARGUMENT;
    if (start_x && !sm_all_finite(start_x, n)) return SM_NOT_FINITE;
    const int orders = contact->response ? contact->response->orders_count : 0;
    double *memory = calloc(sm_march_size(contact->contacts, orders), sizeof(double));
    if (!memory) return SM_NO_MEMORY;
    sm_march march;
    sm_march_place(&march, contact->contacts, orders, memory);
    sm_march_start(&march, start_x, NULL, NULL);
    size_t g = 0;
    double now = segment[0].start;
    for (size_t k = 0; k < samples && status == SM_OK; k++) {
        while (now < times[k] && status == SM_OK) {
            const double end = sm_segment_end(&segment[g]);
            if (now >= end && g + 1 < segments) {
                g++;
                continue;
            }
            const double to = times[k] < end || g + 1 == segments ? times[k] : end;
            status = sm_march_along(&march, contact, &segment[g], now - segment[g].start,
                                    to - segment[g].start, steps_per_period);
            now = to;
        }
        if (displacement) memcpy(displacement + k * n, march.lane.x, n * sizeof(double));
        if (velocity) memcpy(velocity + k * n, march.lane.v, n * sizeof(double));
        if (force) memcpy(force + k * n, march.force, n * sizeof(double));
    }
    free(memory);
    return status;
}
