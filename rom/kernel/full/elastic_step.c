/* One implicit step with elastic contacts: elastic_step.h states the equations. */
#include "full/elastic_step.h"

void sm_elastic_step_place(sm_elastic_step *s, const sm_full *full, size_t width,
                           sm_block *block) {
    const sm_elastic *elastic = full->elastic;
    const size_t n = (size_t)full->contacts;
    *s = (sm_elastic_step){
        .contacts = n, .width = width, .remembered = sm_elastic_memory(elastic)};
    SM_TAKE_EACH(block, width, &s->own, &s->ahead);
    SM_TAKE_EACH(block, n * width, &s->directions, &s->gather);
    SM_TAKE_EACH(block, n, &s->u, &s->x_c, &s->v_c);
    s->memory = sm_take(block, s->remembered);
    sm_elastic_solver_place(&s->solver, elastic, full->contacts, full->flexibility, block);
}

void sm_elastic_step_set(sm_elastic_step *s, const sm_full *full) {
    const size_t n = (size_t)full->coordinates;
    const double *reference = full->elastic->reference;
    memcpy(s->own, full->own, n * sizeof(double));
    memcpy(s->ahead, full->ahead, n * sizeof(double));
    for (size_t i = 0; i < s->contacts; i++) {
        memcpy(s->directions + i * s->width, full->directions + i * n, n * sizeof(double));
        for (size_t j = 0; j < s->contacts; j++) {
            const double part = (i == j) - full->flexibility[i * s->contacts + j] * reference[j];
            for (size_t k = 0; k < n; k++)
                s->gather[i * s->width + k] += part * full->directions[j * n + k];
        }
    }
}

/* Sets base_q = q + b v and base_v = v + b a; without contact forces, stage_v has the velocities
 * and `load` the displacements at the end of the step. */
SM_INLINE void move_freely(const sm_elastic_step *s, sm_esdirk4 *m, const double *force) {
    const double *restrict ahead = s->ahead, *restrict own = s->own;
    SM_EACH(k, s->width) {
        m->base_q[k] = m->q[k] + ahead[k] * m->v[k];
        m->base_v[k] = m->v[k] + ahead[k] * m->stage_dv[k];
    }
    sm_esdirk4_free(m, force, m->stage_v);
    SM_EACH(k, s->width) m->load[k] = m->base_q[k] + own[k] * m->stage_v[k];
}

SM_HOT sm_status sm_elastic_step_take(sm_elastic_step *s, sm_esdirk4 *m, double elapsed) {
    const size_t width = s->width;
    double force[SM_MODES] = {0.0};
    sm_carrier_force(&m->carrier, SM_ESDIRK4_STAGES - 1, elapsed, force);
    move_freely(s, m, force);
    for (size_t i = 0; i < s->contacts; i++)
        s->u[i] = sm_full_dot(s->gather + i * width, m->load, width);
    SM_TRY(sm_elastic_solve(&s->solver, s->u, s->memory, s->x_c));
    double *restrict after = m->stage_v;
    for (size_t i = 0; i < s->contacts; i++) {
        const double now = s->solver.f[i];
        const double *restrict response = m->response + i * width;
        SM_EACH(k, width) after[k] -= response[k] * now;
        m->dissipated += 0.5 * (m->force[i] + now) * (s->x_c[i] - m->x_c[i]);
        m->force[i] = now;
        m->x_c[i] = s->x_c[i];
    }
    const double *restrict own = s->own;
    SM_EACH(k, width) {
        m->stage_dv[k] = (after[k] - m->base_v[k]) * m->per_step[k];
        m->v[k] = after[k];
        m->q[k] = m->base_q[k] + own[k] * after[k];
    }
    memcpy(s->memory, s->solver.next, s->remembered * sizeof(double));
    sm_carrier_advance(&m->carrier);
    return SM_OK;
}

void sm_elastic_step_velocity(sm_elastic_step *s, const double *v) {
    for (size_t i = 0; i < s->contacts; i++)
        s->v_c[i] = sm_full_dot(s->directions + i * s->width, v, s->width);
}
