/* The stage problem S v + g(v) = r of stepper.h: semismooth Newton with a line search, in lanes.
 *
 * The solution is the minimum of the strictly convex potential
 *   v.S v / 2 - r.v + sum_i integral_0^v_i g_i,
 * whose gradient is minus the residual r - S v - g(v). Each step solves J u = residual with
 * J = S + diag g'(v); a contact that sticks under Coulomb friction has the slope g' = infinity. A
 * contact whose velocity would change its sign stops at zero. A step at whose end the potential
 * rises is shortened: so the method converges from anywhere. Called by tr_bdf2.h and one.c.
 */
#ifndef SLIPMODE_NEWTON_H
#define SLIPMODE_NEWTON_H

#include "base/check.h"
#include "contact/stage/factor.h"
#include "contact/stepper.h"

/* Steps at the most, many times what was ever seen. */
#define SM_NEWTON_STEPS 1000
/* Steps until the line search becomes strict. The line search accepts a step if the slope of the
 * potential at its end is at most a part of the slope at its start, with opposite sign: first a large
 * part, because steps slightly beyond the minimum are good; then rounding, so that the potential
 * never rises. */
#define SM_LENIENT_STEPS 10
#define SM_LENIENT_RISE 0.5
#define SM_STRICT_RISE 1e-6
/* Velocity in alpha beyond which tanh is 1 to rounding. */
#define SM_TANH_FLAT 20.0
/* Change of velocity in alpha up to which a Newton step cannot raise the potential: the slope of tanh
 * changes by a factor of exp(2 x) at most in x, and (exp(2 x) - 1 - 2 x) / (2 x)^2 is below 1. */
#define SM_SHORT_STEP 0.8
/* Change of velocity in alpha from which a change of sign is a passage through zero from slip to
 * slip: inside, where tanh is nearly linear, a step may change the sign. */
#define SM_TANH_KINK 2.0

/* Sets m->v to a rough solution by sweeps of Gauss-Seidel over the contacts. Under tanh friction
 * after two of them nearly all contacts that stick or slip are known. */
SM_INLINE void sm_guess(const int n, const int lanes, const sm_stepper *s, sm_lanes *m) {
    const int sweeps = s->sticks ? 1 : 2;
    for (int sweep = 0; sweep < sweeps; sweep++)
        for (int i = 0; i < n - sweep; i++) { /* the last one is up to date */
            const sm_resolvent *f = &s->laws[i];
            const double *restrict r = m->r + i * lanes;
            double *restrict v = m->v + i * lanes;
            double y[SM_LANES];
            sm_row_times(n, lanes, s->matrix + (size_t)i * n, m->v, y);
            SM_SIMD
            for (int l = 0; l < lanes; l++) y[l] = r[l] - (y[l] - f->s * v[l]);
            sm_velocity_guess(lanes, f, y, v);
        }
}

/* Computes friction g(v), its slope and the residual at m->v. The factor of a lane on its own stays
 * valid in the rows before the first contact whose slope has changed. */
SM_INLINE void sm_linearise(const int n, const int lanes, const sm_stepper *s, sm_lanes *m) {
    int rows = lanes == 1 ? m->rows : 0;
    sm_times(n, lanes, s->matrix, m->v, m->residual);
    for (int i = 0; i < n; i++) {
        const double *restrict r = m->r + i * lanes;
        double *restrict residual = m->residual + i * lanes, *restrict g = m->g + i * lanes;
        double *restrict slope = m->slope + i * lanes;
        const double before = slope[0];
        SM_SIMD
        for (int l = 0; l < lanes; l++) residual[l] = r[l] - residual[l];
        sm_friction_force(lanes, &s->laws[i], m->v + i * lanes, residual, g, slope);
        SM_SIMD
        for (int l = 0; l < lanes; l++) residual[l] -= g[l];
        if (slope[0] != before && i < rows) rows = i;
    }
    m->rows = rows;
}

/* Closes the lanes whose residual is below SM_STAGE_TOLERANCE of the forces that meet at the contact,
 * limit_i + |r_i| + sum_j |S_ij v_j|: without the last, rounding alone could exceed the tolerance
 * where there is no friction and r_i passes through zero. SM_OK if that closes the last one. */
SM_INLINE sm_status sm_close_balanced(const int n, const int lanes, const sm_stepper *s,
                                const sm_lanes *m, double *restrict open) {
    double norm[SM_LANES] = {0.0};
    double largest = 0.0, left = 0.0;
    for (int i = 0; i < n; i++) {
        const double *restrict r = m->r + i * lanes, *restrict residual = m->residual + i * lanes;
        const double limit = s->laws[i].limit;
        double force[SM_LANES];
        SM_SIMD
        for (int l = 0; l < lanes; l++) force[l] = limit + fabs(r[l]) + SM_TINY;
        for (int j = 0; j < n; j++) {
            const double s_ij = s->matrix[(size_t)i * n + j];
            const double *restrict v = m->v + j * lanes;
            SM_SIMD
            for (int l = 0; l < lanes; l++) force[l] += fabs(s_ij * v[l]);
        }
        SM_SIMD
        for (int l = 0; l < lanes; l++) {
            const double relative = fabs(residual[l]) / force[l];
            const double ordered = relative < INFINITY ? relative : INFINITY;
            norm[l] = ordered > norm[l] ? ordered : norm[l];
        }
    }
    for (int l = 0; l < lanes; l++) {
        open[l] = norm[l] <= SM_STAGE_TOLERANCE ? 0.0 : open[l];
        largest = norm[l] > largest ? norm[l] : largest;
        left += open[l];
    }
    return left == 0.0       ? SM_OK
           : largest < INFINITY ? SM_NOT_CONVERGED
                             : SM_NOT_FINITE;
}

/* Lets contacts stick that begin to slip in m->step against the force on them. Not all contacts of a
 * step do so: it descends. */
SM_INLINE void sm_hold_back(const int n, const int lanes, const sm_stepper *s, sm_lanes *m) {
    for (int i = n - 1; i >= 0; i--) {
        const double *restrict v = m->v + i * lanes, *restrict step = m->step + i * lanes;
        const double *restrict residual = m->residual + i * lanes;
        double *restrict slope = m->slope + i * lanes, most = 0.0;
        if (!(s->laws[i].limit > 0.0)) continue;
        SM_SIMD_MAX(most)
        for (int l = 0; l < lanes; l++) {
            const double against = v[l] == 0.0 ? -step[l] * residual[l] : 0.0;
            slope[l] = against > 0.0 ? INFINITY : slope[l];
            most = against > most ? against : most;
        }
        if (most > 0.0) m->rows = i;
    }
}

/* Adds J^-1 (-g'' step^2 / 2) to the step of tanh contacts, where it is short. */
SM_INLINE void sm_correct(const int n, const int lanes, const sm_stepper *s, sm_lanes *m) {
    double *restrict bend = m->before; /* free until the step is made */
    for (int i = 0; i < n; i++) {
        const double per_alpha = s->laws[i].per_alpha, per_steepest = s->laws[i].per_steepest;
        const double *restrict g = m->g + i * lanes, *restrict slope = m->slope + i * lanes;
        const double *restrict step = m->step + i * lanes;
        SM_SIMD
        for (int l = 0; l < lanes; l++) {
            const double x = step[l] * per_alpha, bent = g[l] * slope[l] * per_steepest * x * x;
            bend[i * lanes + l] = fabs(x) < SM_SHORT_STEP ? bent : 0.0;
        }
    }
    sm_divide(n, lanes, m->factor, bend);
    for (int k = 0; k < n * lanes; k++) m->step[k] += bend[k];
}

/* Solves J step = residual, and corrects the step by the curvature of tanh: Chebyshev's iteration,
 * which takes three steps where Newton's takes four. */
SM_INLINE void sm_find_step(const int n, const int lanes, const sm_stepper *s, sm_lanes *m,
                            int corrected) {
    const size_t size = (size_t)n * (size_t)lanes;
    do {
        sm_factorise(n, lanes, s->matrix, m->slope, n > 2 ? m->rows : 0, m->factor);
        m->rows = n;
        for (size_t k = 0; k < size; k++) m->step[k] = m->residual[k];
        sm_divide(n, lanes, m->factor, m->step);
        if (s->sticks) sm_hold_back(n, lanes, s, m);
    } while (m->rows < n);
    if (corrected) sm_correct(n, lanes, s, m);
}

/* Moves the velocities of open lanes by m->step; contacts stop where they would pass through zero.
 * `rest`: the largest residual after it, in limits, which tanh friction leaves by its curvature; 1
 * where no expansion holds. Returns whether a step is long enough for the potential to rise. */
SM_INLINE int sm_move(const int n, const int lanes, const sm_stepper *s, sm_lanes *m,
                      const double *restrict open, double *restrict rest) {
    double longest = s->sticks ? INFINITY : 0.0;
    for (int l = 0; l < lanes; l++) rest[l] = s->sticks ? 1.0 : 0.0;
    for (int i = 0; i < n; i++) {
        const sm_resolvent *f = &s->laws[i];
        const double kink = f->limit > 0.0 ? SM_TANH_KINK * f->alpha * !s->sticks : INFINITY;
        const double per_alpha = f->per_alpha, per_steepest = f->per_steepest;
        double *restrict v = m->v + i * lanes, *restrict before = m->before + i * lanes;
        double *restrict step = m->step + i * lanes;
        const double *restrict slope = m->slope + i * lanes;
        SM_SIMD_MAX(longest)
        for (int l = 0; l < lanes; l++) {
            const double start = v[l], u = open[l] > 0.0 ? step[l] : 0.0, end = start + u;
            const double x = fabs(u) * per_alpha, bent = slope[l] * per_steepest * x * x * x;
            const double least = fabs(start) < fabs(end) ? fabs(start) : fabs(end);
            const int flat = (least * per_alpha > SM_TANH_FLAT) & (start * end > 0.0);
            const double left = (x < SM_SHORT_STEP) | flat ? bent : 1.0;
            step[l] = u;
            before[l] = start;
            v[l] = (start * end < 0.0) & (fabs(u) > kink) ? 0.0 : end;
            rest[l] = left > rest[l] ? left : rest[l];
            longest = x > longest ? x : longest;
        }
    }
    return longest > SM_SHORT_STEP;
}

/* Slope of the potential, with opposite sign, where the last step begins: `work` along the step,
 * `gain` along the motion, in which contacts stop. */
SM_INLINE void sm_descent(const int n, const int lanes, const sm_lanes *m, double *restrict work,
                          double *restrict gain) {
    for (int l = 0; l < lanes; l++) work[l] = gain[l] = 0.0;
    for (int i = 0; i < n * lanes; i += lanes) {
        SM_SIMD
        for (int l = 0; l < lanes; l++) {
            work[l] += m->step[i + l] * m->residual[i + l];
            gain[l] += (m->v[i + l] - m->before[i + l]) * m->residual[i + l];
        }
    }
}

/* Shortens the steps of lanes at whose end the potential rises by more than a part of `gain`, its
 * slope at the start of the motion: the first time, where `gain` is not `work`, to the first contact
 * that stopped, then by halves. Returns whether there are such lanes. */
SM_INLINE int sm_shorten(const int n, const int lanes, const sm_stepper *s, sm_lanes *m,
                         double *work, const double *gain, int strict) {
    const double allowed = strict ? SM_STRICT_RISE : SM_LENIENT_RISE;
    double end[SM_LANES] = {0.0};
    int shorter = 0;
    for (int i = 0; i < n; i++) {
        /* where friction jumps, the slope is the one before the jump; a steep tanh is like a jump,
         * and the next step finds the place in it */
        const double limit = s->sticks || !strict ? s->laws[i].limit : 0.0;
        const double *restrict v = m->v + i * lanes, *restrict before = m->before + i * lanes;
        const double *restrict residual = m->residual + i * lanes, *restrict g = m->g + i * lanes;
        SM_SIMD
        for (int l = 0; l < lanes; l++) {
            const double moved = v[l] - before[l];
            const double jump = (v[l] == 0.0) & (limit > 0.0) ? g[l] * moved + limit * fabs(moved)
                                                              : 0.0;
            end[l] += residual[l] * moved + jump;
        }
    }
    for (int l = 0; l < lanes; l++) shorter |= end[l] < -allowed * gain[l];
    if (!shorter) return 0;
    for (int l = 0; l < lanes; l++) {
        if (!(end[l] < -allowed * gain[l])) continue;
        double part = 1.0;
        for (int k = l; gain != work && k < n * lanes; k += lanes)
            if (m->v[k] == 0.0 && m->before[k] != 0.0)
                part = fmin(part, -m->before[k] / m->step[k]);
        if (part == 1.0) part = 0.5;
        work[l] *= part;
        for (int k = l; k < n * lanes; k += lanes) {
            m->step[k] *= part;
            const double moved = m->before[k] + m->step[k];
            m->v[k] = fabs(moved) > SM_ROUNDING * fabs(m->before[k]) ? moved : 0.0; /* stops at 0 */
        }
    }
    return 1;
}

/* Solves S v + g(v) = r. Lanes side by side advance in large steps: their initial guess depends on r
 * alone. One lane follows a trajectory in small steps and starts from the previous solution. If its
 * factor is valid, m->v solves the equation for m->last_r: under tanh friction a step with the J of
 * that solution improves the guess. Tanh friction has converged if the curvature of the last step
 * changes the residual by less than s->tolerance. */
SM_INLINE sm_status sm_solve(const int n, const int lanes, const sm_stepper *s, sm_lanes *m) {
    double open[SM_LANES], work[SM_LANES], gain[SM_LANES];
    double rest[SM_LANES] = {0.0};
    const double tolerance = s->tolerance;
    int is_long = 0;
    for (int l = 0; l < lanes; l++) open[l] = 1.0;
    if (lanes > 1) sm_guess(n, lanes, s, m);
    if (lanes == 1 && m->rows == n && !s->sticks) {
        for (int i = 0; i < n; i++) m->step[i] = m->r[i] - m->last_r[i];
        sm_divide(n, lanes, m->factor, m->step);
        sm_correct(n, lanes, s, m);
        for (int i = 0; i < n; i++) m->v[i] += m->step[i];
    }
    for (int i = 0; lanes == 1 && i < n; i++) m->last_r[i] = m->r[i];
    for (int k = 0; k < SM_NEWTON_STEPS; k++) {
        const int strict = k >= SM_LENIENT_STEPS;
        if (is_long) sm_descent(n, lanes, m, work, gain);
        sm_linearise(n, lanes, s, m);
        for (int part = 0; is_long && part < SM_MAX_HALVINGS; part++) {
            is_long = sm_shorten(n, lanes, s, m, work, part == 0 ? gain : work, strict);
            if (is_long) sm_linearise(n, lanes, s, m);
        }
        if (s->sticks || strict) {
            const sm_status status = sm_close_balanced(n, lanes, s, m, open);
            if (status != SM_NOT_CONVERGED) return status;
        }
        sm_find_step(n, lanes, s, m, !s->sticks && !strict);
        is_long = sm_move(n, lanes, s, m, open, rest);
        double left = 0.0;
        for (int l = 0; l < lanes; l++) {
            open[l] = rest[l] < tolerance ? 0.0 : open[l];
            left += open[l];
        }
        if (left == 0.0) return SM_OK;
    }
    return SM_NOT_CONVERGED;
}

#endif
