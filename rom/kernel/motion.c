/* Contact motion along a slow trajectory: eq. (12) marched with the slowly varying amplitudes.
 *
 * Friction forgets its past within a few periods, so the march may start a few periods before
 * the first time asked for; there is no need to start at t = 0.
 */
#include "motion.h"

#include <stdlib.h>

#include "check.h"
#include "cnumber.h"
#include "exact_sum.h"

#define MAX_STEPS 1e10 /* of one march: hours */

size_t sm_march_size(int contacts) {
    return sm_stepper_size(contacts) + sm_lanes_size(contacts, 1);
}

void sm_march_place(sm_march *march, int contacts, double *memory) {
    sm_stepper_place(&march->stepper, contacts, memory);
    sm_lanes_place(&march->lane, contacts, 1, memory + sm_stepper_size(contacts));
}

void sm_march_start(sm_march *march, const double *x, const double *v) {
    for (int i = 0; i < march->stepper.contacts; i++) {
        march->lane.x[i] = x ? x[i] : 0.0;
        march->lane.v[i] = march->lane.stage_v[0][i] = march->lane.stage_v[1][i] = v ? v[i] : 0.0;
    }
}

/* a_j at the fraction r of the segment, by cubic Hermite interpolation. */
static sm_complex amplitude_at(const sm_segment *g, int j, double r) {
    const double r2 = r * r, r3 = r2 * r, end = 3.0 * r2 - 2.0 * r3, start = 1.0 - end;
    const double rate_start = g->duration * (r - 2.0 * r2 + r3);
    const double rate_end = g->duration * (r3 - r2);
    double a[2];
    for (int p = 0; p < 2; p++)
        a[p] = start * g->amplitude_start[2 * j + p] + end * g->amplitude_end[2 * j + p]
               + rate_start * g->rate_start[2 * j + p] + rate_end * g->rate_end[2 * j + p];
    return sm_cx(a[0], a[1]);
}

/* u += Re sum G_nm exp(i (n theta_A + m theta_B)) at the fraction r of the segment. */
static void add_pull(const sm_contact *contact, const sm_segment *g, double r,
                     const sm_complex *carrier, double *u) {
    const int n = contact->contacts;
    for (int q = 0; q < contact->answer->orders_count; q++) {
        const int32_t *order = contact->answer->orders + 2 * q;
        const sm_complex turn = sm_cmul(sm_unit_power(carrier[0], order[0]),
                                        sm_unit_power(carrier[1], order[1]));
        for (int i = 0; i < n; i++) {
            const size_t at = 2 * ((size_t)q * (size_t)n + (size_t)i);
            const double re = g->pull_start[at] + r * (g->pull_end[at] - g->pull_start[at]);
            const double im = g->pull_start[at + 1]
                              + r * (g->pull_end[at + 1] - g->pull_start[at + 1]);
            u[i] += re * turn.re - im * turn.im;
        }
    }
}

/* u = -2 Re sum_j L_j a_j exp(i theta_j) [+ pull] at `elapsed` seconds into the segment. */
static void load_forcing(const sm_contact *contact, const sm_segment *g, double elapsed,
                         double *u) {
    const int n = contact->contacts;
    const double r = elapsed / g->duration;
    sm_complex carrier[SM_MODES] = {{1.0, 0.0}, {1.0, 0.0}};
    for (int i = 0; i < n; i++) u[i] = 0.0;
    for (int j = 0; j < contact->modes; j++) {
        const double angle =
            g->angle[j] + elapsed * (g->frequency[j] + 0.5 * g->frequency_rate[j] * elapsed);
        carrier[j] = sm_cx(cos(angle), sin(angle));
        const sm_complex q = sm_cmul(amplitude_at(g, j, r), carrier[j]);
        const double *L = contact->coupling + 2 * (size_t)j * (size_t)n;
        for (int i = 0; i < n; i++) u[i] -= 2.0 * (L[2 * i] * q.re - L[2 * i + 1] * q.im);
    }
    if (contact->answer && g->pull_start && g->pull_end) add_pull(contact, g, r, carrier, u);
}

sm_status sm_march_along(sm_march *march, const sm_contact *contact, const sm_segment *segment,
                         double from, double to, int steps_per_period) {
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
    for (int64_t k = 0; k < steps; k++) {
        for (int stage = 0; stage < 2; stage++) {
            const double c = stage == 0 ? SM_GAMMA : 1.0;
            load_forcing(contact, segment, from + h * ((double)k + c), march->lane.u);
            status = sm_stage(1, &march->stepper, &march->lane, stage);
            if (status != SM_OK) return status;
        }
    }
    /* a NaN or infinity anywhere on the way is still in the displacement */
    return sm_all_finite(march->lane.x, (size_t)contact->contacts) ? SM_OK : SM_NOT_FINITE;
}

void sm_march_force(const sm_march *march, double *force) {
    const int n = march->stepper.contacts;
    for (int i = 0; i < n; i++) {
        /* y = S_ii v + g(v), where rounding must not carry g beyond the limit */
        const double g = march->lane.y[i] - march->stepper.matrix[i * n + i] * march->lane.v[i];
        force[i] = fmax(-march->stepper.laws[i].limit, fmin(g, march->stepper.laws[i].limit));
    }
}

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

static double end_of(const sm_segment *segment) { return segment->start + segment->duration; }

/* Whether one segment starts where the other ends, to rounding. */
static int consecutive(const sm_segment *segment, const sm_segment *next) {
    const double gap = fabs(next->start - end_of(segment));
    return next->start > segment->start &&
           gap <= 1e-6 * segment->duration + 1e-9 * fabs(segment->start);
}

static sm_status check_segments(const sm_segment *segment, size_t segments, int modes) {
    if (segments < 1 || !segment) return SM_BAD_ARGUMENT;
    for (size_t k = 0; k < segments; k++) {
        const sm_status status = check_segment(&segment[k], modes);
        if (status != SM_OK) return status;
        if (k > 0 && !consecutive(&segment[k - 1], &segment[k])) return SM_BAD_ARGUMENT;
    }
    return SM_OK;
}

static sm_status check_times(size_t samples, const double *times, double start, double end) {
    if (samples == 0) return SM_OK;
    if (!times) return SM_BAD_ARGUMENT;
    if (!sm_all_finite(times, samples)) return SM_NOT_FINITE;
    if (!(times[0] >= start && times[samples - 1] <= end)) return SM_BAD_ARGUMENT;
    for (size_t k = 1; k < samples; k++)
        if (!(times[k] > times[k - 1])) return SM_BAD_ARGUMENT;
    return SM_OK;
}

sm_status sm_contact_motion(const sm_contact *contact, size_t segments, const sm_segment *segment,
                            const double *start_x, int32_t steps_per_period, size_t samples,
                            const double *times, double *displacement, double *velocity,
                            double *force) {
    sm_status status = sm_contact_check(contact);
    if (status == SM_OK) status = check_segments(segment, segments, contact->modes);
    if (status != SM_OK) return status;
    const sm_segment *last = &segment[segments - 1];
    status = check_times(samples, times, segment->start, end_of(last) + 1e-9 * last->duration);
    if (status != SM_OK) return status;
    const size_t n = (size_t)contact->contacts;
    if (steps_per_period < 4 || steps_per_period > 65536 || !sm_fits(samples, n * sizeof(double)))
        return SM_BAD_ARGUMENT;
    if (start_x && !sm_all_finite(start_x, n)) return SM_NOT_FINITE;
    double *memory = calloc(sm_march_size(contact->contacts), sizeof(double));
    if (!memory) return SM_NO_MEMORY;
    sm_march march;
    sm_march_place(&march, contact->contacts, memory);
    sm_march_start(&march, start_x, NULL);
    size_t g = 0;
    double now = segment[0].start;
    for (size_t k = 0; k < samples && status == SM_OK; k++) {
        while (now < times[k] && status == SM_OK) {
            const double end = end_of(&segment[g]);
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
        if (force) sm_march_force(&march, force + k * n);
    }
    free(memory);
    return status;
}
