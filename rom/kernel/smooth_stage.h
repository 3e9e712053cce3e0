/* The stage problem S v + g(v) = r of many lanes under tanh friction.
 *
 * With the others moving as they are thought to, a contact has a solution whose shape is known: it
 * sticks, slides, or is in the knee between. From there two or three steps of Chebyshev's cubic
 * iteration on the coupled problem end far below the error of the time steps, at one tanh a
 * contact and step. Where they do not, sm_solve_stage takes over.
 */
#ifndef SLIPMODE_SMOOTH_STAGE_H
#define SLIPMODE_SMOOTH_STAGE_H

#include "contact.h"

#define SM_SMOOTH_TOLERANCE 1e-12 /* of the friction limits: what is left of the residual */
#define SM_SMOOTH_STEPS 6
#define SM_FLAT 20.0 /* v / alpha from which tanh is 1 to rounding */

/* Velocity m->v of each contact by itself, roughly, one after another. They are asked twice: where
 * a contact changes between stick and slip, those asked before it should know. In large steps one
 * stage in ten would otherwise be beyond Chebyshev's reach. */
SM_INLINE void sm_smooth_guess(const int n, const int lanes, const sm_stepper *s, sm_lanes *m) {
    for (int sweep = 0; sweep < 2; sweep++)
        for (int i = 0; i < n - sweep; i++) { /* the last one was asked last */
            const sm_resolvent *f = &s->laws[i];
            const double inv_limit = 1.0 / f->limit;
            const double *restrict r = m->r + i * lanes;
            double *restrict y = m->y + i * lanes, *restrict v = m->v + i * lanes;
            SM_SIMD
            for (int l = 0; l < lanes; l++) y[l] = r[l];
            for (int j = 0; j < n; j++) {
                if (j == i) continue;
                const double s_ij = s->matrix[i * n + j];
                const double *restrict moved = m->v + j * lanes;
                SM_SIMD
                for (int l = 0; l < lanes; l++) y[l] -= s_ij * moved[l];
            }
            SM_SIMD
            for (int l = 0; l < lanes; l++)
                v[l] = copysign(f->alpha * sm_tanh_guess(f, fabs(y[l]) * inv_limit), y[l]);
        }
}

/* Residual r - g(v) - S v, friction force g(v) and slope sech^2 at m->v. */
SM_INLINE void sm_smooth_linearise(const int n, const int lanes, const sm_stepper *s,
                                   sm_lanes *m) {
    for (int i = 0; i < n; i++) {
        const double limit = s->laws[i].limit, per_alpha = 1.0 / s->laws[i].alpha;
        const double *restrict r = m->r + i * lanes, *restrict v = m->v + i * lanes;
        double *restrict g = m->y + i * lanes, *restrict sech2 = m->d + i * lanes;
        double *restrict residual = m->residual + i * lanes;
        SM_SIMD
        for (int l = 0; l < lanes; l++) {
            const double w = v[l] * per_alpha;
            const double e = sm_exp_negative(-2.0 * fabs(w)), inv = 1.0 / (1.0 + e);
            g[l] = limit * sm_tanh_from(w, e, inv);
            sech2[l] = 4.0 * e * inv * inv;
            residual[l] = r[l] - g[l];
        }
        for (int j = 0; j < n; j++) {
            const double s_ij = s->matrix[i * n + j];
            const double *restrict moved = m->v + j * lanes;
            SM_SIMD
            for (int l = 0; l < lanes; l++) residual[l] -= s_ij * moved[l];
        }
    }
}

/* The factor L D L^T of J = S + diag g'(v): unit lower triangle, inverse pivots. */
SM_INLINE void sm_smooth_factor(const int n, const int lanes, const sm_stepper *s, sm_lanes *m) {
    double *restrict f = m->factor;
    for (int i = 0; i < n; i++) {
        const double steepest = s->laws[i].limit / s->laws[i].alpha;
        const double *restrict sech2 = m->d + i * lanes;
        double *restrict pivot = f + (size_t)(i * n + i) * lanes;
        SM_SIMD
        for (int l = 0; l < lanes; l++) pivot[l] = s->matrix[i * n + i] + steepest * sech2[l];
        for (int j = 0; j < i; j++) {
            double *restrict entry = f + (size_t)(i * n + j) * lanes;
            SM_SIMD
            for (int l = 0; l < lanes; l++) entry[l] = s->matrix[i * n + j];
            for (int k = 0; k < j; k++) {
                const double *restrict a = f + (size_t)(i * n + k) * lanes;
                const double *restrict b = f + (size_t)(j * n + k) * lanes;
                SM_SIMD
                for (int l = 0; l < lanes; l++) entry[l] -= a[l] * b[l];
            }
        }
        for (int j = 0; j < i; j++) {
            double *restrict entry = f + (size_t)(i * n + j) * lanes;
            const double *restrict inverse = f + (size_t)(j * n + j) * lanes;
            SM_SIMD
            for (int l = 0; l < lanes; l++) {
                const double scaled = entry[l] * inverse[l];
                pivot[l] -= entry[l] * scaled;
                entry[l] = scaled;
            }
        }
        SM_SIMD
        for (int l = 0; l < lanes; l++) pivot[l] = 1.0 / pivot[l];
    }
}

/* x = J^-1 x */
SM_INLINE void sm_smooth_divide(const int n, const int lanes, const sm_lanes *m, double *x) {
    const double *restrict f = m->factor;
    for (int i = 1; i < n; i++)
        for (int j = 0; j < i; j++) {
            SM_SIMD
            for (int l = 0; l < lanes; l++)
                x[i * lanes + l] -= f[(size_t)(i * n + j) * lanes + l] * x[j * lanes + l];
        }
    for (int i = n - 1; i >= 0; i--) {
        SM_SIMD
        for (int l = 0; l < lanes; l++) x[i * lanes + l] *= f[(size_t)(i * n + i) * lanes + l];
        for (int k = i + 1; k < n; k++) {
            SM_SIMD
            for (int l = 0; l < lanes; l++)
                x[i * lanes + l] -= f[(size_t)(k * n + i) * lanes + l] * x[k * lanes + l];
        }
    }
}

/* One Chebyshev step; what it leaves of the residual at most, relative to the limits. */
SM_INLINE double sm_smooth_iterate(const int n, const int lanes, const sm_stepper *s,
                                   sm_lanes *m) {
    double left = 0.0;
    sm_smooth_linearise(n, lanes, s, m);
    sm_smooth_factor(n, lanes, s, m);
    sm_smooth_divide(n, lanes, m, m->residual);
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
    sm_smooth_divide(n, lanes, m, m->u);
    for (int k = 0; k < n * lanes; k++) m->v[k] += m->u[k];
    return left;
}

SM_INLINE int sm_smooth_solve_for(const int n, const int lanes, const sm_stepper *s,
                                  sm_lanes *m) {
    sm_smooth_guess(n, lanes, s, m);
    for (int k = 0; k < SM_SMOOTH_STEPS; k++)
        if (sm_smooth_iterate(n, lanes, s, m) < SM_SMOOTH_TOLERANCE) return 1;
    return 0;
}

SM_INLINE sm_status sm_smooth_solve(const int lanes, const sm_stepper *s, sm_lanes *m) {
    int solved = 0;
    if (s->smooth)
        solved = s->contacts == 2   ? sm_smooth_solve_for(2, lanes, s, m)
                 : s->contacts == 1 ? sm_smooth_solve_for(1, lanes, s, m)
                                    : sm_smooth_solve_for(s->contacts, lanes, s, m);
    if (solved) return SM_OK;
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
