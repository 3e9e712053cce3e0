/* The one-lane solver of chebyshev.h for n contacts; n is a literal for two.
 *
 * Two contacts are compiled apart, warm_two.c, without vector instructions: marches take 20 % longer
 * otherwise.
 */
#ifndef SLIPMODE_WARM_ITERATION_H
#define SLIPMODE_WARM_ITERATION_H

#include "contact/stage/newton_cg.h"
#include "contact/stage/chebyshev.h"

/* Newton's method from lane->v for lane->r, if Chebyshev's iteration does not converge; and by
 * conjugate gradients, which returns whether they were enough. */
sm_status sm_warm_newton(const sm_stepper *s, sm_lanes *lane);
int sm_warm_newton_cg(const sm_stepper *s, sm_lanes *lane);

/* Of two contacts. */
sm_status sm_warm_solve_two(const sm_stepper *s, sm_warm *warm, sm_lanes *lane);
sm_status sm_stage_two(const sm_stepper *s, sm_warm *warm, sm_lanes *lane, double *pull,
                       int stage);

SM_INLINE void sm_copy_few(const int n, const double *from, double *to) {
    for (int i = 0; i < n; i++) to[i] = from[i];
}

/* The inverse of J of two contacts, with a single division: its diagonal, then the off-diagonal
 * entry. The slopes of friction are multiplied by `scale`. */
SM_INLINE void sm_warm_invert_two(const sm_stepper *s, sm_warm *warm, const double *scale,
                                  const double *slope) {
    const double *S = s->matrix;
    const double a = S[0] * scale[0] + slope[0], b = S[3] * scale[1] + slope[1];
    const double both = scale[0] * scale[1];
    const double inverse = 1.0 / (a * b - S[1] * S[1] * both);
    warm->factor[0] = scale[0] * b * inverse;
    warm->factor[1] = scale[1] * a * inverse;
    warm->factor[2] = -S[1] * both * inverse;
}

/* The factor L D L^T of J, or the inverse. */
SM_INLINE void sm_warm_factorise(const int n, const sm_stepper *s, sm_warm *warm) {
    if (n != 2) {
        sm_tanh_factor(n, 1, s, warm->sech2, warm->factor);
        return;
    }
    const double scale[2] = {1.0, 1.0};
    const double slope[2] = {s->laws[0].limit * warm->per_alpha * warm->sech2[0],
                             s->laws[1].limit * warm->per_alpha * warm->sech2[1]};
    sm_warm_invert_two(s, warm, scale, slope);
}

/* Friction tanh(v / alpha) and its slope, and the factor of J there. */
SM_INLINE void sm_warm_linearise(const int n, const sm_stepper *s, sm_warm *warm) {
    double *restrict tanh = warm->tanh, *restrict sech2 = warm->sech2;
    double scale[2], slope[2]; /* of two contacts: (1 + e)^2, times which there is no division */
    for (int i = 0; i < n; i++) {
        const double w = warm->next[i] * warm->per_alpha;
        const double e = sm_exp_negative(-2.0 * fabs(w)), inv = 1.0 / (1.0 + e);
        tanh[i] = sm_tanh_from(w, e, inv);
        sech2[i] = 4.0 * e * inv * inv;
        if (n != 2) continue;
        scale[i] = (1.0 + e) * (1.0 + e);
        slope[i] = s->laws[i].limit * warm->per_alpha * 4.0 * e;
    }
    if (n == 2)
        sm_warm_invert_two(s, warm, scale, slope);
    else
        sm_warm_factorise(n, s, warm);
}

/* x = J^-1 x */
SM_INLINE void sm_warm_divide(const int n, const sm_warm *warm, double *restrict x) {
    if (n != 2) {
        sm_tanh_divide(n, 1, warm->factor, x);
        return;
    }
    const double *restrict f = warm->factor;
    const double first = x[0];
    x[0] = f[0] * first + f[2] * x[1];
    x[1] = f[2] * first + f[1] * x[1];
}

/* Moves `next` by Chebyshev's step, J^-1 delta and its correction by the curvature of g; returns
 * whether the remaining error is below the tolerance. */
SM_INLINE int sm_warm_move(const int n, const sm_stepper *s, sm_warm *warm) {
    int small = 1, settled = 1;
    sm_warm_divide(n, warm, warm->delta);
    for (int i = 0; i < n; i++) {
        const double x = warm->delta[i] * warm->per_alpha;
        const double curved = warm->sech2[i] * x * x;
        warm->bend[i] = s->laws[i].limit * warm->tanh[i] * curved; /* -g'' delta^2 / 2 */
        small = small && fabs(x) < 1.0;
        settled = settled && curved * fabs(x) < warm->tolerance;
        warm->next[i] += warm->delta[i];
    }
    if (!small) return 0; /* beyond the reach of the expansion: a Newton step alone */
    sm_warm_divide(n, warm, warm->bend);
    for (int i = 0; i < n; i++) warm->next[i] += warm->bend[i];
    return settled;
}

/* One Chebyshev step from `next`; returns whether it ends at the solution. */
SM_INLINE int sm_warm_iterate(const int n, const sm_stepper *s, sm_warm *warm, const double *r) {
    sm_warm_linearise(n, s, warm);
    for (int i = 0; i < n; i++) {
        double sum = r[i] - s->laws[i].limit * warm->tanh[i];
        for (int j = 0; j < n; j++) sum -= s->matrix[i * n + j] * warm->next[j];
        warm->delta[i] = sum;
    }
    return sm_warm_move(n, s, warm);
}

SM_INLINE sm_status sm_warm_solve_in(const int n, const sm_stepper *s, sm_warm *warm,
                                     sm_lanes *lane) {
    const int tries = warm->per_alpha > 0.0 ? 4 : 0;
    sm_copy_few(n, warm->v, lane->v);
    if (s->smooth && n >= SM_FEWEST_FOR_CG && sm_warm_newton_cg(s, lane)) {
        sm_copy_few(n, lane->r, warm->r);
        sm_copy_few(n, lane->v, warm->v);
        return SM_OK;
    }
    if (n >= SM_FEWEST_FOR_CG && lane->factors_for == SM_FACTORS_FOR) {
        /* the factor is an old one */
        sm_copy_few(n, warm->v, warm->next);
        sm_warm_linearise(n, s, warm);
    }
    if (tries > 0) {
        for (int i = 0; i < n; i++) warm->delta[i] = lane->r[i] - warm->r[i];
        sm_copy_few(n, warm->v, warm->next);
        sm_warm_move(n, s, warm);
    }
    sm_copy_few(n, lane->r, warm->r);
    for (int k = 0; k < tries; k++)
        if (sm_warm_iterate(n, s, warm, lane->r)) {
            sm_copy_few(n, warm->next, warm->v);
            return SM_OK;
        }
    sm_copy_few(n, warm->v, lane->v);
    const sm_status status = sm_warm_newton(s, lane);
    sm_copy_few(n, lane->v, warm->v);
    sm_copy_few(n, lane->v, warm->next);
    if (tries > 0) sm_warm_linearise(n, s, warm);
    return status;
}

#endif
