/* The stage problem S v + g(v) = r of any law, by semismooth Newton in y, see sdirk2.h.
 *
 * If Newton does not converge, a method that descends on the potential from anywhere takes over:
 * active_set.h, or under tanh friction Gauss-Seidel sweeps. So the step cannot fail.
 */
#ifndef SLIPMODE_NEWTON_H
#define SLIPMODE_NEWTON_H

#include "contact/stage/active_set.h"

/* Largest residual of each lane into norm, relative to the forces that meet at the contact,
 * limit_i + |r_i| + sum_j |S_ij v_j|: without the last, rounding alone could exceed the tolerance
 * where there is no friction and r_i passes through zero. Infinite if one is NaN. */
SM_INLINE void sm_residual(const int lanes, const sm_stepper *s, sm_lanes *m,
                           double *restrict norm) {
    const int n = s->contacts;
    for (int l = 0; l < lanes; l++) norm[l] = 0.0;
    for (int i = 0; i < n; i++) {
        double *restrict res = m->residual + (size_t)i * lanes;
        const double *restrict y = m->y + (size_t)i * lanes, *restrict r = m->r + (size_t)i * lanes;
        const double limit = s->laws[i].limit;
        double force[SM_LANES];
        SM_SIMD
        for (int l = 0; l < lanes; l++) {
            res[l] = y[l] - r[l];
            force[l] = limit + fabs(r[l]) + 1e-300;
        }
        for (int j = 0; j < n; j++) {
            if (j == i) continue;
            const double s_ij = s->matrix[i * n + j];
            const double *restrict v = m->v + (size_t)j * lanes;
            SM_SIMD
            for (int l = 0; l < lanes; l++) {
                const double from_j = s_ij * v[l];
                res[l] += from_j;
                force[l] += fabs(from_j);
            }
        }
        SM_SIMD
        for (int l = 0; l < lanes; l++) {
            const double relative = fabs(res[l]) / force[l];
            const double ordered = relative < INFINITY ? relative : INFINITY;
            norm[l] = ordered > norm[l] ? ordered : norm[l];
        }
    }
}

/* dy = -residual + S_off z, z being what the update of y changes v by. */
SM_INLINE void sm_newton_move(const int lanes, const sm_stepper *s, sm_lanes *m,
                              const double *z) {
    const int n = s->contacts;
    for (int i = 0; i < n; i++) {
        double *restrict y = m->y + (size_t)i * lanes;
        const double *restrict res = m->residual + (size_t)i * lanes;
        SM_SIMD
        for (int l = 0; l < lanes; l++) y[l] -= res[l];
        for (int j = 0; j < n; j++) {
            if (j == i) continue;
            const double s_ij = s->matrix[i * n + j];
            const double *restrict from = z + (size_t)j * lanes;
            SM_SIMD
            for (int l = 0; l < lanes; l++) y[l] += s_ij * from[l];
        }
    }
}

/* Newton update of y. With v = D y (D = dv/dy, diagonal) the symmetric form is
 *   (I + D^1/2 S_off D^1/2) w = D^1/2 residual,   dy = -residual + S_off D^1/2 w. */
SM_INLINE void sm_newton(const int lanes, const sm_stepper *s, sm_lanes *m) {
    const int n = s->contacts;
    if (n == 2) {
        const double off = s->matrix[1];
        double *restrict y0 = m->y, *restrict y1 = m->y + lanes;
        const double *restrict d0 = m->d, *restrict d1 = m->d + lanes;
        const double *restrict r0 = m->residual, *restrict r1 = m->residual + lanes;
        SM_SIMD
        for (int l = 0; l < lanes; l++) {
            const double inv = 1.0 / (1.0 - off * off * d0[l] * d1[l]);
            y0[l] -= (r0[l] - off * d1[l] * r1[l]) * inv;
            y1[l] -= (r1[l] - off * d0[l] * r0[l]) * inv;
        }
        return;
    }
    double *restrict f = m->factor;
    for (size_t k = 0; k < (size_t)n * (size_t)lanes; k++) m->d[k] = sqrt(m->d[k]);
    /* Cholesky factor, unit diagonal plus the coupling between sliding contacts */
    for (int i = 0; i < n; i++)
        for (int j = 0; j <= i; j++) {
            double *restrict a = f + ((size_t)i * n + j) * lanes;
            const double *restrict row_i = f + (size_t)i * n * lanes;
            const double *restrict row_j = f + (size_t)j * n * lanes;
            const double *restrict d_i = m->d + (size_t)i * lanes;
            const double *restrict d_j = m->d + (size_t)j * lanes;
            const double s_ij = i == j ? 0.0 : s->matrix[i * n + j];
            double sum[SM_LANES];
            SM_SIMD
            for (int l = 0; l < lanes; l++) sum[l] = i == j ? 1.0 : s_ij * d_i[l] * d_j[l];
            for (int k = 0; k < j; k++) {
                SM_SIMD
                for (int l = 0; l < lanes; l++)
                    sum[l] -= row_i[(size_t)k * lanes + l] * row_j[(size_t)k * lanes + l];
            }
            SM_SIMD
            for (int l = 0; l < lanes; l++)
                a[l] = i == j ? sqrt(sum[l]) : sum[l] / row_j[(size_t)j * lanes + l];
        }
    double *restrict w = m->u; /* free between the forcing and the next stage */
    for (int l = 0; l < lanes; l++) {
        for (int i = 0; i < n; i++) {
            double sum = m->d[i * lanes + l] * m->residual[i * lanes + l];
            for (int k = 0; k < i; k++) sum -= f[((size_t)i * n + k) * lanes + l] * w[k * lanes + l];
            w[i * lanes + l] = sum / f[((size_t)i * n + i) * lanes + l];
        }
        for (int i = n - 1; i >= 0; i--) {
            double sum = w[i * lanes + l];
            for (int k = i + 1; k < n; k++)
                sum -= f[((size_t)k * n + i) * lanes + l] * w[k * lanes + l];
            w[i * lanes + l] = sum / f[((size_t)i * n + i) * lanes + l];
        }
    }
    for (size_t k = 0; k < (size_t)n * (size_t)lanes; k++) w[k] *= m->d[k];
    sm_newton_move(lanes, s, m, w);
}

SM_INLINE void sm_resolve_all(const int lanes, const sm_stepper *s, sm_lanes *m) {
    for (int i = 0; i < s->contacts; i++)
        sm_resolve(lanes, &s->laws[i], m->y + (size_t)i * lanes, m->v + (size_t)i * lanes,
                   m->d + (size_t)i * lanes);
}

/* One sweep of coordinate descent on the potential: never ascends, converges from anywhere. */
SM_INLINE void sm_gauss_seidel(const int lanes, const sm_stepper *s, sm_lanes *m) {
    const int n = s->contacts;
    for (int i = 0; i < n; i++) {
        double *restrict y = m->y + (size_t)i * lanes;
        const double *restrict r = m->r + (size_t)i * lanes;
        SM_SIMD
        for (int l = 0; l < lanes; l++) y[l] = r[l];
        for (int j = 0; j < n; j++) {
            if (j == i) continue;
            const double s_ij = s->matrix[i * n + j];
            const double *restrict v = m->v + (size_t)j * lanes;
            SM_SIMD
            for (int l = 0; l < lanes; l++) y[l] -= s_ij * v[l];
        }
        sm_resolve(lanes, &s->laws[i], y, m->v + (size_t)i * lanes, m->d + (size_t)i * lanes);
    }
}

/* Solve S v + g(v) = r for the lanes; v holds the initial guess.
 *
 * Coulomb friction: the active set, which is the fastest for one lane; side by side in lanes a
 * Gauss-Seidel sweep solves most stages before it at a fraction of the cost. Two contacts, whose
 * Newton steps are two lines, take half the time by these (benchmarks/contact_solves.py). */
SM_INLINE sm_status sm_newton_solve(const int lanes, const sm_stepper *s, sm_lanes *m) {
    const int n = s->contacts, coulomb = s->laws[0].law == SM_COULOMB;
    const int newton_only = !coulomb ? 8 : n == 2 ? 3 : 0, mixed = 40, sweeps = 20000;
    int newton_works = 1, by_newton = 0;
    double norm[SM_LANES];
    if (coulomb && lanes == 1 && n > 2) {
        norm[0] = 1.0;
        return sm_active_set_all(lanes, s, m, norm);
    }
    for (int iteration = 0; iteration < sweeps; iteration++) {
        if (by_newton) {
            sm_newton(lanes, s, m);
            sm_resolve_all(lanes, s, m);
        } else {
            sm_gauss_seidel(lanes, s, m);
        }
        if (n == 1) return SM_OK; /* a sweep is exact for one contact */
        double worst = 0.0;
        sm_residual(lanes, s, m, norm);
        for (int l = 0; l < lanes; l++) worst = norm[l] > worst ? norm[l] : worst;
        if (worst <= SM_STAGE_TOLERANCE) return SM_OK;
        if (coulomb && (iteration == newton_only || !(worst < INFINITY)))
            return sm_active_set_all(lanes, s, m, norm);
        if (!(worst < INFINITY)) { /* Newton met a singular matrix, or the data overflow */
            if (!newton_works) return SM_NOT_FINITE;
            newton_works = 0;
            memset(m->v, 0, (size_t)n * (size_t)lanes * sizeof(double));
        }
        by_newton = newton_works && (iteration < newton_only ||
                                     (iteration < mixed && iteration % 2 == 0));
    }
    return SM_NOT_CONVERGED;
}

#endif
