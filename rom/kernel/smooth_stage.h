/* The stage problem S v + g(v) = r of many lanes under tanh friction.
 *
 * With the others moving as they are thought to, a contact has a solution whose shape is known: it
 * sticks, slides, or is in the knee between. From there two or three steps of Chebyshev's cubic
 * iteration on the coupled problem end far below the error of the time steps, at one tanh a
 * contact and step. Where they do not, sm_solve_stage takes over.
 */
#ifndef SLIPMODE_SMOOTH_STAGE_H
#define SLIPMODE_SMOOTH_STAGE_H

#include "many_stage.h"

#define SM_SMOOTH_STEPS 6
#define SM_FLAT 20.0 /* v / alpha from which tanh is 1 to rounding */

/* One Chebyshev step; what it leaves of the residual at most, relative to the limits. */
SM_INLINE double sm_smooth_iterate(const int n, const int lanes, const sm_stepper *s,
                                   sm_lanes *m) {
    double left = 0.0;
    sm_tanh_linearise(n, lanes, s, m);
    sm_tanh_factor(n, lanes, s, m);
    sm_tanh_divide(n, lanes, m, m->residual);
    for (int i = 0; i < n; i++) {
        const double per_alpha = 1.0 / s->laws[i].alpha;
        const double *restrict g = m->y + i * lanes, *restrict sech2 = m->d + i * lanes;
        const double *restrict delta = m->residual + i * lanes;
        double *restrict bend = m->u + i * lanes, *restrict v = m->v + i * lanes;
        SM_SIMD_MAX(left)
        for (int l = 0; l < lanes; l++) {
            const double x = delta[l] * per_alpha, curved = sech2[l] * x * x;
            const double before = fabs(v[l]), moved = v[l] + delta[l];
            const double after = g[l] > 0.0 ? moved : -moved;
            const double least = (after < before ? after : before) * per_alpha;
            /* beyond the reach of the expansion a Newton step alone, right where g is flat */
            const double rest = x * x < 1.0 || least > SM_FLAT ? curved * fabs(x) : 1.0;
            const double ordered = rest < INFINITY ? rest : INFINITY;
            left = ordered > left ? ordered : left;
            bend[l] = x * x < 1.0 ? g[l] * curved : 0.0; /* -g'' delta^2 / 2 */
            v[l] = moved;
        }
    }
    sm_tanh_divide(n, lanes, m, m->u);
    for (int k = 0; k < n * lanes; k++) m->v[k] += m->u[k];
    return left;
}

SM_INLINE int sm_smooth_solve_for(const int n, const int lanes, const sm_stepper *s,
                                  sm_lanes *m) {
    sm_tanh_guess_all(n, lanes, s, m);
    for (int k = 0; k < SM_SMOOTH_STEPS; k++)
        if (sm_smooth_iterate(n, lanes, s, m) < SM_SMOOTH_TOLERANCE) return 1;
    return 0;
}

SM_INLINE int sm_smooth_solve_any(const int lanes, const sm_stepper *s, sm_lanes *m) {
    if (s->contacts == 1) return sm_smooth_solve_for(1, lanes, s, m);
    if (s->contacts == 2) return sm_smooth_solve_for(2, lanes, s, m);
    return sm_many_try(s->contacts, lanes, s, m) || sm_smooth_solve_for(s->contacts, lanes, s, m);
}

SM_INLINE sm_status sm_smooth_solve(const int lanes, const sm_stepper *s, sm_lanes *m) {
    if (s->smooth && sm_smooth_solve_any(lanes, s, m)) return SM_OK;
    if (s->smooth) memset(m->v, 0, (size_t)s->contacts * (size_t)lanes * sizeof(double));
    return sm_solve_stage(lanes, s, m);
}

/* One stage: forcing in m->u; velocity into m->v. */
SM_INLINE sm_status sm_stage(const int lanes, const sm_stepper *s, sm_lanes *m, int stage) {
    sm_stage_begin(lanes, s, m, stage);
    memcpy(m->v, m->stage_v[stage], (size_t)s->contacts * (size_t)lanes * sizeof(double));
    const sm_status status = sm_smooth_solve(lanes, s, m);
    sm_stage_end(lanes, s, m, stage);
    return status;
}

#endif
