/* The stage problem S v + g(v) = r of many tanh contacts: Newton's method, its steps by conjugate
 * gradients.
 *
 * A factor of J = S + diag g'(v) costs N_c^3, a product with S N_c^2. A few products are enough, as
 * the diagonal of J is a good preconditioner: it dominates where contacts stick, and sliding contacts
 * have springs of their own. Each step of Newton is solved no further than its own error, and
 * shortened if it passes the minimum of the potential along it. If stiff springs join the contacts
 * and conjugate gradients would take long, factors are used.
 */
#ifndef SLIPMODE_NEWTON_CG_H
#define SLIPMODE_NEWTON_CG_H

#include "base/products.h"
#include "contact/stage/newton.h"

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

/* The factor L D L^T of J = S + diag g'(v), from the slopes sech2 (n, lanes) of tanh: unit lower
 * triangle, inverse pivots. */
SM_INLINE void sm_tanh_factor(const int n, const int lanes, const sm_stepper *s,
                              const double *restrict sech2, double *restrict f) {
    for (int i = 0; i < n; i++) {
        const double steepest = s->laws[i].limit / s->laws[i].alpha;
        double *restrict pivot = f + (size_t)(i * n + i) * lanes;
        SM_SIMD
        for (int l = 0; l < lanes; l++)
            pivot[l] = s->matrix[i * n + i] + steepest * sech2[i * lanes + l];
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
SM_INLINE void sm_tanh_divide(const int n, const int lanes, const double *restrict f,
                              double *restrict x) {
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

#define SM_FEWEST_FOR_CG 32 /* contacts from which this is faster than factors */
#define SM_NEWTON_CG_STEPS 20
#define SM_FACTORS_FOR 16 /* stages after one that conjugate gradients took too long for */

/* Largest residual of each lane, relative to the forces at the contact, and of them all; infinite
 * if one is NaN. */
SM_INLINE double sm_newton_cg_norm(const int n, const int lanes, const sm_stepper *s, const sm_lanes *m,
                              double *restrict norm) {
    for (int l = 0; l < lanes; l++) norm[l] = 0.0;
    for (int i = 0; i < n; i++) {
        const double limit = s->laws[i].limit, s_ii = s->matrix[(size_t)i * n + i];
        const double *restrict r = m->r + i * lanes, *restrict v = m->v + i * lanes;
        const double *restrict residual = m->residual + i * lanes;
        SM_SIMD
        for (int l = 0; l < lanes; l++) {
            const double force = limit + fabs(r[l]) + s_ii * fabs(v[l]);
            const double relative = fabs(residual[l]) / force;
            const double ordered = relative < INFINITY ? relative : INFINITY;
            norm[l] = ordered > norm[l] ? ordered : norm[l];
        }
    }
    double worst = 0.0;
    for (int l = 0; l < lanes; l++) worst = norm[l] > worst ? norm[l] : worst;
    return worst;
}

/* u = J^-1 residual, until the residual of each lane has shrunk to the part `goal` of it; whether
 * they get there. */
SM_INLINE int sm_conjugate_gradients(const int n, const int lanes, const sm_stepper *s, sm_lanes *m,
                           const double *restrict goal) {
    const size_t size = (size_t)n * (size_t)lanes;
    double *restrict u = m->u, *restrict residual = m->residual;
    double *restrict p = m->conjugate, *restrict q = p + size, *restrict inverse = q + size;
    const double *restrict sech2 = m->d;
    double rz[SM_LANES] = {0.0}, enough[SM_LANES];
    for (int i = 0; i < n; i++) {
        const double s_ii = s->matrix[(size_t)i * n + i];
        const double steepest = s->laws[i].limit / s->laws[i].alpha;
        SM_SIMD
        for (int l = 0; l < lanes; l++) {
            const int k = i * lanes + l;
            inverse[k] = 1.0 / (s_ii + steepest * sech2[k]);
            u[k] = 0.0;
            p[k] = inverse[k] * residual[k];
            rz[l] += p[k] * residual[k];
        }
    }
    for (int l = 0; l < lanes; l++) enough[l] = goal[l] * goal[l] * rz[l];
    for (int iteration = 0; iteration < n / 2; iteration++) {
        double pq[SM_LANES] = {0.0}, part[SM_LANES], fresh[SM_LANES] = {0.0};
        sm_times(n, lanes, s->matrix, p, q);
        for (int i = 0; i < n; i++) {
            const double steepest = s->laws[i].limit / s->laws[i].alpha;
            SM_SIMD
            for (int l = 0; l < lanes; l++) {
                const int k = i * lanes + l;
                q[k] += steepest * sech2[k] * p[k];
                pq[l] += p[k] * q[k];
            }
        }
        for (int l = 0; l < lanes; l++) part[l] = pq[l] > 0.0 ? rz[l] / pq[l] : 0.0;
        for (int i = 0; i < n; i++) {
            SM_SIMD
            for (int l = 0; l < lanes; l++) {
                const int k = i * lanes + l;
                u[k] += part[l] * p[k];
                residual[k] -= part[l] * q[k];
                fresh[l] += inverse[k] * residual[k] * residual[k];
            }
        }
        int open = 0;
        for (int l = 0; l < lanes; l++) {
            open |= !(fresh[l] <= enough[l]);
            part[l] = rz[l] > 0.0 ? fresh[l] / rz[l] : 0.0;
            rz[l] = fresh[l];
        }
        if (!open) return 1;
        for (int i = 0; i < n; i++) {
            SM_SIMD
            for (int l = 0; l < lanes; l++) {
                const int k = i * lanes + l;
                p[k] = inverse[k] * residual[k] + part[l] * p[k];
            }
        }
    }
    return 0;
}

/* dot = sum_i u_i f_i */
SM_INLINE void sm_newton_cg_work(const int n, const int lanes, const double *restrict u,
                            const double *restrict f, double *restrict dot) {
    for (int l = 0; l < lanes; l++) dot[l] = 0.0;
    for (int i = 0; i < n; i++) {
        SM_SIMD
        for (int l = 0; l < lanes; l++) dot[l] += u[i * lanes + l] * f[i * lanes + l];
    }
}

/* The step just taken, back to about the minimum of the potential along it; whether it had gone
 * beyond. `start`: the work of the residual along the step, where it began. */
SM_INLINE int sm_newton_cg_retreat(const int n, const int lanes, sm_lanes *m,
                              const double *restrict norm, double *restrict start) {
    double end[SM_LANES], part[SM_LANES];
    int beyond = 0;
    sm_newton_cg_work(n, lanes, m->u, m->residual, end);
    for (int l = 0; l < lanes; l++) {
        const int far = end[l] < -0.5 * start[l] && norm[l] > SM_SMOOTH_TOLERANCE;
        part[l] = far ? start[l] / (start[l] - end[l]) : 1.0;
        start[l] *= part[l];
        beyond |= far;
    }
    if (!beyond) return 0;
    for (int i = 0; i < n; i++) {
        SM_SIMD
        for (int l = 0; l < lanes; l++) {
            const int k = i * lanes + l;
            m->v[k] -= (1.0 - part[l]) * m->u[k];
            m->u[k] *= part[l];
        }
    }
    return 1;
}

/* Velocities m->v from a first guess there; whether they were found. */
SM_INLINE int sm_newton_cg(const int n, const int lanes, const sm_stepper *s, sm_lanes *m) {
    const size_t size = (size_t)n * (size_t)lanes;
    double norm[SM_LANES], goal[SM_LANES], start[SM_LANES];
    sm_tanh_guess_all(n, lanes, s, m);
    sm_tanh_linearise(n, lanes, s, m);
    double worst = sm_newton_cg_norm(n, lanes, s, m, norm);
    for (int k = 0; k < SM_NEWTON_CG_STEPS && worst < INFINITY; k++) {
        if (worst < SM_SMOOTH_TOLERANCE) return 1;
        for (int l = 0; l < lanes; l++) {
            const double needed = 0.1 * SM_SMOOTH_TOLERANCE / (norm[l] + SM_SMOOTH_TOLERANCE);
            goal[l] = fmax(fmin(norm[l], 0.1), needed);
        }
        memcpy(m->y, m->residual, size * sizeof(double));
        if (!sm_conjugate_gradients(n, lanes, s, m, goal)) return 0;
        sm_newton_cg_work(n, lanes, m->u, m->y, start);
        for (size_t i = 0; i < size; i++) m->v[i] += m->u[i];
        for (int back = 0; back < SM_NEWTON_CG_STEPS; back++) {
            sm_tanh_linearise(n, lanes, s, m);
            worst = sm_newton_cg_norm(n, lanes, s, m, norm);
            if (!sm_newton_cg_retreat(n, lanes, m, norm, start)) break;
        }
    }
    return 0;
}

/* The same, unless it failed not long ago. */
SM_INLINE int sm_newton_cg_try(const int lanes, const sm_stepper *s, sm_lanes *m) {
    if (m->factors_for > 0)
        m->factors_for--;
    else if (sm_newton_cg(s->contacts, lanes, s, m))
        return 1;
    else
        m->factors_for = SM_FACTORS_FOR;
    return 0;
}

#endif
