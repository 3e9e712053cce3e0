/* Tanh contacts of many lanes: a first guess of their velocities, and Newton's matrix
 * J = S + diag g'(v) with its factor.
 */
#ifndef SLIPMODE_TANH_JACOBIAN_H
#define SLIPMODE_TANH_JACOBIAN_H

#include "contact/stage/newton.h"
#include "base/products.h"

/* A rough estimate of the velocities m->v by two Gauss-Seidel sweeps. One sweep is not enough where
 * a contact changes between stick and slip: in large steps Chebyshev's iteration then fails in one
 * stage of ten. */
SM_INLINE void sm_tanh_guess_all(const int n, const int lanes, const sm_stepper *s, sm_lanes *m) {
    for (int sweep = 0; sweep < 2; sweep++)
        for (int i = 0; i < n - sweep; i++) { /* the last contact of the first sweep is up to date */
            const sm_resolvent *f = &s->laws[i];
            const double inv_limit = 1.0 / f->limit;
            const double *restrict r = m->r + i * lanes;
            double *restrict v = m->v + i * lanes;
            double held[SM_LANES];
            sm_row_times(n, lanes, s->matrix + i * n, m->v, held);
            SM_SIMD
            for (int l = 0; l < lanes; l++) {
                const double y = r[l] - (held[l] - f->s * v[l]);
                v[l] = copysign(f->alpha * sm_tanh_guess(f, fabs(y) * inv_limit), y);
            }
        }
}

/* Residual r - g(v) - S v, friction force g(v) and slope sech^2 at m->v. */
SM_INLINE void sm_tanh_linearise(const int n, const int lanes, const sm_stepper *s,
                                 sm_lanes *m) {
    sm_times(n, lanes, s->matrix, m->v, m->residual);
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
            residual[l] = (r[l] - g[l]) - residual[l];
        }
    }
}

/* The factor L D L^T of J = S + diag g'(v): unit lower triangle, inverse pivots. */
SM_INLINE void sm_tanh_factor(const int n, const int lanes, const sm_stepper *s, sm_lanes *m) {
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
SM_INLINE void sm_tanh_divide(const int n, const int lanes, const sm_lanes *m, double *x) {
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

#endif
