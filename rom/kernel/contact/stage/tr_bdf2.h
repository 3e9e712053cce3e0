/* The stages of TR-BDF2 (Bank et al. 1985): the trapezoidal rule to t + 2 gamma h, then backward
 * differences of second order to t + h.
 *
 * With gamma = 1 - 1/sqrt 2 both stages are the problem of stepper.h with the same S. The method is
 * L-stable: a stuck contact stays exactly where it is. Both stages are of second order, and so are
 * velocities. The number of contacts n and of lanes may be literals. Called by
 * torus/rigid/steps.c and one.c.
 */
#ifndef SLIPMODE_TR_BDF2_H
#define SLIPMODE_TR_BDF2_H

#include "contact/stage/newton.h"

/* Sets m->before to the velocity from which a stage changes: by its own M dv/dt alone, gamma h long. */
SM_INLINE void sm_stage_base_velocity(size_t size, sm_lanes *m, int stage) {
    const double gain = stage == 0 ? 0.0 : SM_BDF_WEIGHT / SM_GAMMA;
    const double *restrict start = m->stage_v[1], *restrict first = m->stage_v[0];
    SM_SIMD
    for (size_t k = 0; k < size; k++) m->before[k] = start[k] + gain * (first[k] - start[k]);
}

/* Sets the right-hand side m->r of a stage from the forcing in m->u. */
SM_INLINE void sm_stage_begin(const int n, const int lanes, const sm_stepper *s, sm_lanes *m,
                              int stage) {
    const size_t size = (size_t)n * (size_t)lanes;
    const double of_start = s->h * (stage == 0 ? SM_GAMMA : SM_BDF_WEIGHT);
    const double of_first = s->h * (stage == 0 ? 0.0 : SM_BDF_WEIGHT);
    const double *restrict start = m->stage_v[1], *restrict first = m->stage_v[0];
    SM_SIMD
    for (size_t k = 0; k < size; k++)
        m->base[k] = m->x[k] + (of_start * start[k] + of_first * first[k]);
    sm_times(n, lanes, s->stiffness, m->base, m->r);
    SM_SIMD
    for (size_t k = 0; k < size; k++) m->r[k] = m->u[k] - m->r[k];
    if (s->massless) return;
    sm_stage_base_velocity(size, m, stage);
    sm_times(n, lanes, s->inertia, m->before, m->residual);
    const double of_inertia = stage == 0 ? 1.0 : 0.0;
    SM_SIMD
    for (size_t k = 0; k < size; k++) m->r[k] += m->residual[k] + of_inertia * m->inertia[k];
}

/* Sets what follows from the velocity m->v of a stage. */
SM_INLINE void sm_stage_end(const int n, const int lanes, const sm_stepper *s, sm_lanes *m,
                            int stage) {
    const size_t size = (size_t)n * (size_t)lanes;
    const double own = SM_GAMMA * s->h;
    if (stage == 1) {
        SM_SIMD
        for (size_t k = 0; k < size; k++) m->x[k] = m->base[k] + own * m->v[k];
    }
    if (stage == 1 && !s->massless) {
        sm_stage_base_velocity(size, m, stage);
        SM_SIMD
        for (size_t k = 0; k < size; k++) m->before[k] = m->v[k] - m->before[k];
        sm_times(n, lanes, s->inertia, m->before, m->inertia);
    }
    memcpy(m->stage_v[stage], m->v, size * sizeof(double));
}

/* Makes a stage: begins at a guess from r alone, or in one lane at the solution before. */
SM_INLINE sm_status sm_stage(const int n, const int lanes, const sm_stepper *s, sm_lanes *m,
                             int stage) {
    sm_stage_begin(n, lanes, s, m, stage);
    const sm_status status = sm_solve(n, lanes, s, m);
    sm_stage_end(n, lanes, s, m, stage);
    return status;
}

#endif
