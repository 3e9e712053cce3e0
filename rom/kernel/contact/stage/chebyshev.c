#include "contact/stage/chebyshev.h"

#include "contact/stage/newton_cg.h"

/* One Chebyshev step; what it leaves of the residual at most, relative to the limits. */
SM_INLINE double iterate(const int n, const int lanes, const sm_stepper *s, sm_lanes *m) {
    double left = 0.0;
    sm_tanh_linearise(n, lanes, s, m);
    sm_tanh_factor(n, lanes, s, m->d, m->factor);
    sm_tanh_divide(n, lanes, m->factor, m->residual);
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
            /* beyond the reach of the expansion a Newton step alone, right where g is flat: tanh is 1
             * to rounding from 20 on */
            const double rest = x * x < 1.0 || least > 20.0 ? curved * fabs(x) : 1.0;
            const double ordered = rest < INFINITY ? rest : INFINITY;
            left = ordered > left ? ordered : left;
            bend[l] = x * x < 1.0 ? g[l] * curved : 0.0; /* -g'' delta^2 / 2 */
            v[l] = moved;
        }
    }
    sm_tanh_divide(n, lanes, m->factor, m->u);
    for (int k = 0; k < n * lanes; k++) m->v[k] += m->u[k];
    return left;
}

/* `n` is a literal where there are few contacts. */
SM_INLINE int chebyshev(const int n, const int lanes, const sm_stepper *s, sm_lanes *m) {
    sm_tanh_guess_all(n, lanes, s, m);
    for (int k = 0; k < 6; k++)
        if (iterate(n, lanes, s, m) < s->tolerance) return 1;
    return 0;
}

SM_INLINE int smooth(const int lanes, const sm_stepper *s, sm_lanes *m) {
    if (s->contacts == 1) return chebyshev(1, lanes, s, m);
    if (s->contacts == 2) return chebyshev(2, lanes, s, m);
    if (s->contacts >= SM_FEWEST_FOR_CG && sm_newton_cg_try(lanes, s, m)) return 1;
    return chebyshev(s->contacts, lanes, s, m);
}

SM_INLINE sm_status solve(const int lanes, const sm_stepper *s, sm_lanes *m) {
    if (s->smooth) {
        if (smooth(lanes, s, m)) return SM_OK;
        memset(m->v, 0, (size_t)(s->contacts * lanes) * sizeof(double));
    }
    return sm_newton_solve(lanes, s, m);
}

SM_HOT static sm_status solve_few(const sm_stepper *s, sm_lanes *m) {
    return solve(SM_FEW_LANES, s, m);
}

SM_HOT static sm_status solve_many(const sm_stepper *s, sm_lanes *m) {
    return solve(SM_LANES, s, m);
}

sm_status sm_solve_lanes(const sm_stepper *s, sm_lanes *m) {
    return m->lanes == SM_FEW_LANES ? solve_few(s, m) : solve_many(s, m);
}

SM_INLINE sm_status stage_of(const int lanes, const sm_stepper *s, sm_lanes *m, int stage) {
    sm_stage_begin(s->contacts, lanes, s, m, stage);
    memcpy(m->v, m->stage_v[stage], (size_t)(s->contacts * lanes) * sizeof(double));
    const sm_status status = sm_solve_lanes(s, m);
    sm_stage_end(s->contacts, lanes, s, m, stage);
    return status;
}

SM_HOT static sm_status stage_few(const sm_stepper *s, sm_lanes *m, int stage) {
    return stage_of(SM_FEW_LANES, s, m, stage);
}

SM_HOT static sm_status stage_many(const sm_stepper *s, sm_lanes *m, int stage) {
    return stage_of(SM_LANES, s, m, stage);
}

sm_status sm_stage_lanes(const sm_stepper *s, sm_lanes *m, int stage) {
    return m->lanes == SM_FEW_LANES ? stage_few(s, m, stage) : stage_many(s, m, stage);
}
