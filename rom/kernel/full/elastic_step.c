#include "full/elastic_step.h"

void sm_elastic_step_place(sm_elastic_step *s, const sm_full *full, size_t width,
                           sm_block *block) {
    const sm_elastic *elastic = full->elastic;
    const size_t n = (size_t)full->contacts;
    *s = (sm_elastic_step){
        .contacts = n, .width = width, .remembered = sm_elastic_memory(elastic)};
    s->own = sm_take(block, width);
    s->ahead = sm_take(block, width);
    s->per_own = sm_take(block, width);
    s->directions = sm_take(block, n * width);
    s->gather = sm_take(block, n * width);
    s->u = sm_take(block, n);
    s->x_c = sm_take(block, n);
    s->v_c = sm_take(block, n);
    s->memory = sm_take(block, s->remembered);
    sm_elastic_solver_place(&s->solver, elastic, full->contacts, full->flexibility, block);
    for (int32_t e = 0; e < elastic->elements; e++) {
        const sm_element *element = &elastic->element[e];
        if (element->law == SM_FRICTIONAL)
            s->static_closure =
                fmax(s->static_closure, element->preload / element->normal_stiffness);
    }
}

void sm_elastic_step_set(sm_elastic_step *s, const sm_full *full) {
    const size_t n = (size_t)full->coordinates;
    const double *reference = full->elastic->reference;
    for (size_t k = 0; k < n; k++) {
        s->own[k] = full->own[k];
        s->ahead[k] = full->ahead[k];
        s->per_own[k] = 1.0 / full->own[k];
    }
    for (size_t i = 0; i < s->contacts; i++) {
        memcpy(s->directions + i * s->width, full->directions + i * n, n * sizeof(double));
        for (size_t j = 0; j < s->contacts; j++) {
            const double part = (i == j) - full->flexibility[i * s->contacts + j] * reference[j];
            for (size_t k = 0; k < n; k++)
                s->gather[i * s->width + k] += part * full->directions[j * n + k];
        }
    }
}

/* The displacement below which the solver finds rounding: it resolves 1e-11 of those that the
 * contacts remember. */
static double least(const sm_elastic_step *s) {
    double largest = s->static_closure;
    for (size_t i = 0; i < s->contacts; i++) largest = fmax(largest, fabs(s->x_c[i]));
    for (size_t i = 0; i < s->remembered; i++) largest = fmax(largest, fabs(s->memory[i]));
    return 1e-3 * largest;
}

/* base_q = q + b v, and the velocities v_1 that contacts without forces would leave, in stage_v;
 * what they lead to in `load`. */
SM_INLINE void move_freely(const sm_elastic_step *s, sm_esdirk4 *m, const double *force) {
    const size_t width = s->width;
    const double *restrict q = m->q, *restrict v = m->v, *restrict a = m->stage_dv;
    const double *restrict own = s->own, *restrict ahead = s->ahead, *restrict per = s->per_own;
    const double *restrict stiffness = m->stiffness, *restrict inverse = m->inverse;
    const double *restrict first = m->pattern_response, *restrict second = first + width;
    double *restrict base_q = m->base_q, *restrict load = m->load, *restrict after = m->stage_v;
    const double f_0 = force[0], f_1 = force[1];
    if (m->diagonal) {
        SM_EACH(k, width) {
            const double moved = q[k] + ahead[k] * v[k];
            const double pushed = (v[k] + ahead[k] * a[k]) * per[k] - stiffness[k] * moved;
            const double now = inverse[k] * pushed + first[k] * f_0 + second[k] * f_1;
            base_q[k] = moved;
            after[k] = now;
            load[k] = moved + own[k] * now;
        }
        return;
    }
    SM_EACH(k, width) {
        base_q[k] = q[k] + ahead[k] * v[k];
        load[k] = (v[k] + ahead[k] * a[k]) * per[k] - stiffness[k] * base_q[k];
    }
    sm_esdirk4_divide(m, after);
    SM_EACH(k, width) {
        after[k] += first[k] * f_0 + second[k] * f_1;
        load[k] = base_q[k] + own[k] * after[k];
    }
}

SM_HOT sm_status sm_elastic_step_take(sm_elastic_step *s, sm_esdirk4 *m, double elapsed) {
    const size_t width = s->width;
    double force[SM_MODES] = {0.0};
    sm_carrier_force(&m->carrier, SM_ESDIRK4_STAGES - 1, elapsed, force);
    move_freely(s, m, force);
    for (size_t i = 0; i < s->contacts; i++)
        s->u[i] = sm_full_dot(s->gather + i * width, m->load, width);
    s->solver.least = least(s);
    const sm_status status = sm_elastic_solve(&s->solver, s->u, s->memory, s->x_c);
    if (status != SM_OK) return status;
    double *restrict after = m->stage_v;
    for (size_t i = 0; i < s->contacts; i++) {
        const double now = s->solver.f[i];
        const double *restrict response = m->response + i * width;
        SM_EACH(k, width) after[k] -= response[k] * now;
        m->dissipated += 0.5 * (m->force[i] + now) * (s->x_c[i] - m->x_c[i]);
        m->force[i] = now;
        m->x_c[i] = s->x_c[i];
    }
    double *restrict q = m->q, *restrict v = m->v, *restrict a = m->stage_dv;
    const double *restrict own = s->own, *restrict ahead = s->ahead, *restrict per = s->per_own;
    const double *restrict base_q = m->base_q;
    SM_EACH(k, width) {
        a[k] = (after[k] - v[k] - ahead[k] * a[k]) * per[k];
        v[k] = after[k];
        q[k] = base_q[k] + own[k] * after[k];
    }
    memcpy(s->memory, s->solver.next, s->remembered * sizeof(double));
    sm_carrier_advance(&m->carrier);
    return SM_OK;
}

void sm_elastic_step_velocity(sm_elastic_step *s, const double *v) {
    for (size_t i = 0; i < s->contacts; i++)
        s->v_c[i] = sm_full_dot(s->directions + i * s->width, v, s->width);
}
