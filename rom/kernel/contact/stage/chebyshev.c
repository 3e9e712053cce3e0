#include "contact/stage/chebyshev.h"

#include "contact/stage/newton_cg.h"

#define FEWEST_FOR_CG 16 /* contacts from which that is faster than factors */
#define STEPS 6
#define FLAT 20.0 /* v / alpha from which tanh is 1 to rounding */

/* One Chebyshev step; what it leaves of the residual at most, relative to the limits. */
SM_INLINE double iterate(const int n, const sm_stepper *s, sm_lanes *m) {
    double left = 0.0;
    sm_tanh_linearise(n, SM_LANES, s, m);
    sm_tanh_factor(n, SM_LANES, s, m);
    sm_tanh_divide(n, SM_LANES, m, m->residual);
    for (int i = 0; i < n; i++) {
        const double per_alpha = 1.0 / s->laws[i].alpha;
        const double *restrict g = m->y + i * SM_LANES, *restrict sech2 = m->d + i * SM_LANES;
        const double *restrict delta = m->residual + i * SM_LANES;
        double *restrict bend = m->u + i * SM_LANES, *restrict v = m->v + i * SM_LANES;
        SM_SIMD_MAX(left)
        for (int l = 0; l < SM_LANES; l++) {
            const double x = delta[l] * per_alpha, curved = sech2[l] * x * x;
            const double before = fabs(v[l]), moved = v[l] + delta[l];
            const double after = g[l] > 0.0 ? moved : -moved;
            const double least = (after < before ? after : before) * per_alpha;
            /* beyond the reach of the expansion a Newton step alone, right where g is flat */
            const double rest = x * x < 1.0 || least > FLAT ? curved * fabs(x) : 1.0;
            const double ordered = rest < INFINITY ? rest : INFINITY;
            left = ordered > left ? ordered : left;
            bend[l] = x * x < 1.0 ? g[l] * curved : 0.0; /* -g'' delta^2 / 2 */
            v[l] = moved;
        }
    }
    sm_tanh_divide(n, SM_LANES, m, m->u);
    for (int k = 0; k < n * SM_LANES; k++) m->v[k] += m->u[k];
    return left;
}

/* `n` is a literal where there are few contacts. */
SM_INLINE int chebyshev(const int n, const sm_stepper *s, sm_lanes *m) {
    sm_tanh_guess_all(n, SM_LANES, s, m);
    for (int k = 0; k < STEPS; k++)
        if (iterate(n, s, m) < SM_SMOOTH_TOLERANCE) return 1;
    return 0;
}

SM_HOT static int newton_cg(const sm_stepper *s, sm_lanes *m) {
    return sm_newton_cg_try(SM_LANES, s, m);
}

SM_HOT static sm_status newton(const sm_stepper *s, sm_lanes *m) {
    return sm_newton_solve(SM_LANES, s, m);
}

SM_HOT static int smooth(const sm_stepper *s, sm_lanes *m) {
    if (s->contacts == 1) return chebyshev(1, s, m);
    if (s->contacts == 2) return chebyshev(2, s, m);
    if (s->contacts >= FEWEST_FOR_CG && newton_cg(s, m)) return 1;
    return chebyshev(s->contacts, s, m);
}

sm_status sm_solve_lanes(const sm_stepper *s, sm_lanes *m) {
    if (s->smooth && smooth(s, m)) return SM_OK;
    if (s->smooth) memset(m->v, 0, (size_t)s->contacts * SM_LANES * sizeof(double));
    return newton(s, m);
}

SM_HOT sm_status sm_stage_lanes(const sm_stepper *s, sm_lanes *m, int stage) {
    sm_stage_begin(s->contacts, SM_LANES, s, m, stage);
    memcpy(m->v, m->stage_v[stage], (size_t)s->contacts * SM_LANES * sizeof(double));
    const sm_status status = sm_solve_lanes(s, m);
    sm_stage_end(s->contacts, SM_LANES, s, m, stage);
    return status;
}
