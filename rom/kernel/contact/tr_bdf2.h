/* One lane of the contact problem, [M x'' +] D x' + K x + g(x') = u(t), by TR-BDF2.
 *
 * Bank et al. (1985): the trapezoidal rule to t + 2 gamma h, backward differences of second order
 * from there to t + h. With gamma = 1 - 1/sqrt 2 both stages solve the stage problem of sdirk2.h,
 * and what follows t + h does not see what t left undecided. Unlike there, its stages are of second
 * order, and so are velocities where displacements follow the forces and M hardly matters; the error
 * of SDIRK2's velocities is a third of their change in a step.
 */
#ifndef SLIPMODE_TR_BDF2_H
#define SLIPMODE_TR_BDF2_H

#include "contact/sdirk2.h"

#define SM_TR_END (2.0 * SM_GAMMA)        /* of the first stage, in steps */
#define SM_TR_WEIGHT 0.35355339059327376  /* of the first two velocities in the second stage */

/* Velocity at the start, and how much of M dv/dt until the second stage the first one took. */
SM_INLINE double sm_tr_bdf2_from(const sm_lanes *m, int i, int stage) {
    const double start = m->stage_v[1][i];
    return stage == 0 ? start
                      : start + SM_TR_WEIGHT / SM_GAMMA * (m->stage_v[0][i] - start);
}

/* Right-hand side m->r of a stage, 0 or 1, from the forcing in m->u. `pull` (N_c) is M dv/dt where
 * the step starts, stage_v[1] the velocity there until that stage is solved. `n` is N_c, and may be
 * a literal. */
SM_INLINE void sm_tr_bdf2_begin(const int n, const sm_stepper *s, sm_lanes *m, const double *pull,
                                int stage) {
    const double h = s->h;
    for (int i = 0; i < n; i++) {
        const double start = m->stage_v[1][i], first = m->stage_v[0][i];
        m->base[i] = m->x[i] + h * (stage == 0 ? SM_GAMMA * start : SM_TR_WEIGHT * (first + start));
    }
    for (int i = 0; i < n; i++) {
        double r = m->u[i];
        for (int j = 0; j < n; j++) r -= s->stiffness[i * n + j] * m->base[j];
        if (!s->massless) {
            for (int j = 0; j < n; j++) r += s->inertia[i * n + j] * sm_tr_bdf2_from(m, j, stage);
            if (stage == 0) r += pull[i];
        }
        m->r[i] = r;
    }
}

/* What follows from the velocity m->v of a stage. */
SM_INLINE void sm_tr_bdf2_end(const int n, const sm_stepper *s, sm_lanes *m, double *pull,
                              int stage) {
    for (int i = 0; stage == 1 && i < n; i++) {
        m->x[i] = m->base[i] + SM_GAMMA * s->h * m->v[i];
        pull[i] = 0.0;
        for (int j = 0; !s->massless && j < n; j++)
            pull[i] += s->inertia[i * n + j] * (m->v[j] - sm_tr_bdf2_from(m, j, 1));
    }
    for (int i = 0; i < n; i++) m->stage_v[stage][i] = m->v[i];
}

#endif
