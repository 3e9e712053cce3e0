/* Contact motion along a slow trajectory: eq. (12) marched with the slowly varying amplitudes.
 *
 * Friction forgets its past within a few periods, so the march may start a few periods before
 * the first time asked for; there is no need to start at t = 0.
 */
#include "slow/motion/contact_motion.h"

#include <stdlib.h>

#include "base/block.h"
#include "base/check.h"
#include "base/exact_sum.h"
#include "slow/motion/segment.h"

#define MAX_STEPS 1e10 /* of one march: hours */
/* Tolerances of v / alpha: S magnifies what it is off by where the force is read. */
#define ON_THE_WAY 1e-7
#define AT_THE_END 1e-10

static size_t remembered(const sm_contact *contact) {
    return contact->law == SM_ELASTIC ? sm_elastic_memory(contact->elastic) : 0;
}

size_t sm_march_size(const sm_contact *contact, int orders) {
    const size_t n = (size_t)contact->contacts;
    const size_t common = sm_reaction_size(contact->contacts, orders) + n;
    if (contact->law == SM_ELASTIC)
        return common + n * n + 4 * n + remembered(contact)
               + sm_elastic_solver_size(contact->elastic, contact->contacts);
    return common + sm_stepper_size(contact->contacts) + sm_lanes_size(contact->contacts, 1)
           + sm_warm_size(contact->contacts);
}

void sm_march_place(sm_march *march, const sm_contact *contact, int orders, double *memory) {
    const int contacts = contact->contacts;
    const size_t n = (size_t)contacts;
    march->force = sm_take(&memory, n);
    sm_reaction_place(&march->reaction, contacts, orders,
                      sm_take(&memory, sm_reaction_size(contacts, orders)));
    if (contact->law == SM_ELASTIC) {
        march->flexibility = sm_take(&memory, n * n);
        for (size_t k = 0; k < n * n; k++) march->flexibility[k] = -contact->stiffness[k];
        double **rows[] = {&march->u, &march->last_u, &march->x, &march->v};
        for (size_t k = 0; k < sizeof rows / sizeof *rows; k++) *rows[k] = sm_take(&memory, n);
        march->memory = sm_take(&memory, remembered(contact));
        sm_elastic_solver_place(&march->solver, contact->elastic, contacts, march->flexibility,
                                memory);
        return;
    }
    sm_stepper_place(&march->stepper, contacts, memory);
    memory += sm_stepper_size(contacts);
    sm_lanes_place(&march->lane, contacts, 1, memory);
    memory += sm_lanes_size(contacts, 1);
    sm_warm_place(&march->warm, contacts, memory);
    march->x = march->lane.x;
    march->v = march->lane.v;
}

size_t sm_march_state_count(const sm_contact *contact) {
    const size_t n = (size_t)contact->contacts;
    return 3 * n + (contact->law == SM_ELASTIC ? n + remembered(contact) : 0);
}

void sm_march_start(sm_march *march, const sm_contact *contact, const double *state) {
    const size_t n = (size_t)contact->contacts;
    for (size_t i = 0; i < n; i++) {
        march->x[i] = state ? state[i] : 0.0;
        march->v[i] = state ? state[n + i] : 0.0;
        march->force[i] = state ? state[2 * n + i] : 0.0;
    }
    if (contact->law == SM_ELASTIC) {
        for (size_t i = 0; i < n; i++) march->last_u[i] = state ? state[3 * n + i] : 0.0;
        for (size_t k = 0; k < remembered(contact); k++)
            march->memory[k] = state ? state[4 * n + k] : 0.0;
        return;
    }
    for (size_t i = 0; i < n; i++)
        march->lane.stage_v[0][i] = march->lane.stage_v[1][i] = march->v[i];
}

void sm_march_read(const sm_march *march, const sm_contact *contact, double *state) {
    const size_t n = (size_t)contact->contacts, bytes = n * sizeof(double);
    memcpy(state, march->x, bytes);
    memcpy(state + n, march->v, bytes);
    memcpy(state + 2 * n, march->force, bytes);
    if (contact->law != SM_ELASTIC) return;
    memcpy(state + 3 * n, march->last_u, bytes);
    memcpy(state + 4 * n, march->memory, remembered(contact) * sizeof(double));
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

/* A step to displacements u of contacts that stick; it takes h seconds. */
static sm_status step_elastic(sm_march *march, const sm_contact *contact, double h) {
    const int n = contact->contacts;
    double *moved = march->v;
    for (int i = 0; i < n; i++) {
        moved[i] = march->x[i];
        march->x[i] += march->u[i] - march->last_u[i]; /* as if nothing slipped */
    }
    const sm_status status = sm_elastic_solve(&march->solver, march->u, march->memory, march->x);
    if (status != SM_OK) return status;
    for (int i = 0; i < n; i++) {
        march->v[i] = (march->x[i] - moved[i]) / h;
        march->last_u[i] = march->u[i];
        march->force[i] = march->solver.f[i];
    }
    memcpy(march->memory, march->solver.next, remembered(contact) * sizeof(double));
    return SM_OK;
}

static sm_status march_elastic(sm_march *march, const sm_contact *contact,
                               const sm_segment *segment, double from, double h, int64_t steps) {
    sm_rotor rotor;
    const int reacting = contact->response && segment->reaction_start && segment->reaction_end;
    if (reacting) sm_reaction_start(&march->reaction, contact->contacts, segment);
    for (int64_t k = 0; k < steps; k++) {
        const double elapsed = from + h * (double)(k + 1);
        if (k % SM_ROTOR_STEPS == 0)
            sm_rotor_start(&rotor, segment, contact->modes, elapsed, h);
        else
            sm_rotor_advance(&rotor, contact->modes);
        load_forcing(contact, segment, elapsed, rotor.carrier, march->u);
        if (reacting)
            load_reaction(&march->reaction, contact, segment, k, 0, elapsed, &rotor, march->u);
        const sm_status status = step_elastic(march, contact, h);
        if (status != SM_OK) return status;
    }
    const size_t n = (size_t)contact->contacts;
    return sm_all_finite(march->x, n) && sm_all_finite(march->v, n) &&
                   sm_all_finite(march->force, n)
               ? SM_OK : SM_NOT_FINITE;
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
    if (contact->law == SM_ELASTIC) return march_elastic(march, contact, segment, from, h, steps);
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
    double *memory =
        calloc(sm_march_size(contact, orders) + sm_march_state_count(contact), sizeof(double));
    if (!memory) return SM_NO_MEMORY;
    double *state = memory + sm_march_size(contact, orders);
    if (start_x) memcpy(state, start_x, n * sizeof(double));
    sm_march march;
    sm_march_place(&march, contact, orders, memory);
    sm_march_start(&march, contact, state);
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
        if (displacement) memcpy(displacement + k * n, march.x, n * sizeof(double));
        if (velocity) memcpy(velocity + k * n, march.v, n * sizeof(double));
        if (force) memcpy(force + k * n, march.force, n * sizeof(double));
    }
    free(memory);
    return status;
}
