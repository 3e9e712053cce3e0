/* The stage problem S v + g(v) = r of one lane under exact Coulomb friction, from anywhere.
 *
 * Its potential v.S v / 2 - r.v + sum_i limit_i |v_i| is a strictly convex quadratic function as
 * long as no velocity changes its sign. An active-set method (Nocedal and Wright, Numerical
 * Optimization, 2006, section 16.5) goes to the minimum of the piece it is on. Where no velocity
 * passes through zero on the way, the contacts that stick under more than their limit begin to
 * slip. Those that would pass stick; if the potential rises by that, the step ends at the last
 * zero before it rises, and that contact sticks alone. Each step goes down and no minimum comes
 * twice: it ends after finitely many of them, at a cost of N_c^2 each.
 */
#ifndef SLIPMODE_ACTIVE_SET_H
#define SLIPMODE_ACTIVE_SET_H

#include <math.h>
#include <stddef.h>
#include <stdint.h>

#include "contact/sdirk2.h"

/* The contacts that slip under Coulomb friction, and the Cholesky factor of S over them.
 *
 * Newton's matrix for exact Coulomb friction is S_AA, of the slipping contacts alone. From one
 * stage to the next few contacts begin or cease to slip: one that begins is a row at the end of
 * the factor, one that ceases is taken out by rotations, each at a cost of N_c^2.
 */

typedef struct {
    int32_t *count;  /* of the slipping contacts */
    int32_t *order;  /* (N_c) their numbers, in the order of the factor's rows */
    int32_t *place;  /* (N_c) row of each contact, counted from 1; 0: it sticks */
    double *factor;  /* (N_c, N_c), lower triangle */
} sm_slipping;

/* int32_t of one lane, as doubles */
static inline size_t sm_slipping_counts(size_t contacts) { return contacts + 1; }

static inline sm_slipping sm_slipping_of(int contacts, int lane, double *counts, double *factor) {
    const size_t n = (size_t)contacts, l = (size_t)lane;
    int32_t *own = (int32_t *)(void *)(counts + l * sm_slipping_counts(n));
    return (sm_slipping){own, own + 2, own + 2 + n, factor + l * n * n};
}

static inline void sm_slipping_forget(const sm_slipping *a, int contacts) {
    *a->count = 0;
    for (int i = 0; i < contacts; i++) a->place[i] = 0;
}

static inline void sm_slipping_add(const sm_slipping *a, int n, const double *matrix, int i) {
    const int row = (*a->count)++;
    double *fresh = a->factor + (size_t)row * (size_t)n;
    for (int j = 0; j <= row; j++) {
        const double *earlier = a->factor + (size_t)j * (size_t)n;
        double sum = matrix[(size_t)i * (size_t)n + (size_t)(j < row ? a->order[j] : i)];
        for (int k = 0; k < j; k++) sum -= fresh[k] * earlier[k];
        fresh[j] = j < row ? sum / earlier[j] : sum;
    }
    /* where S is singular rounding may leave nothing of a pivot, or less */
    const double least = 1e-14 * matrix[(size_t)i * (size_t)n + (size_t)i];
    fresh[row] = sqrt(fresh[row] > least ? fresh[row] : least);
    a->order[row] = i;
    a->place[i] = row + 1;
}

static inline void sm_slipping_remove(const sm_slipping *a, int n, int i) {
    const int gone = a->place[i] - 1, last = --*a->count;
    a->place[i] = 0;
    for (int row = gone; row < last; row++) {
        double *f = a->factor + (size_t)row * (size_t)n;
        for (int k = 0; k <= row + 1; k++) f[k] = f[(size_t)n + (size_t)k];
        a->order[row] = a->order[row + 1];
        a->place[a->order[row]] = row + 1;
    }
    for (int k = gone; k < last; k++) { /* the row moved up has an entry right of the diagonal */
        double *f = a->factor + (size_t)k * (size_t)n;
        const double length = sqrt(f[k] * f[k] + f[k + 1] * f[k + 1]);
        const double c = f[k] / length, s = f[k + 1] / length;
        for (int row = k; row < last; row++, f += n) {
            const double along = c * f[k] + s * f[k + 1];
            f[k + 1] = c * f[k + 1] - s * f[k];
            f[k] = along;
        }
    }
}

/* z = S_AA^-1 z over the slipping contacts, in the order of the rows. */
static inline void sm_slipping_divide(const sm_slipping *a, int n, double *restrict z) {
    const int count = *a->count;
    for (int i = 0; i < count; i++) {
        const double *f = a->factor + (size_t)i * (size_t)n;
        double sum = z[i];
        for (int k = 0; k < i; k++) sum -= f[k] * z[k];
        z[i] = sum / f[i];
    }
    for (int i = count - 1; i >= 0; i--) {
        const double *f = a->factor + (size_t)i * (size_t)n;
        z[i] /= f[i];
        for (int k = 0; k < i; k++) z[k] -= f[k] * z[i];
    }
}

#define SM_DESCENT_FRESH 64  /* steps between factors made anew: rotations round */

typedef struct {
    int contacts;
    double *v, *before; /* velocity, now and before the step */
    double *unbalanced; /* minus the slope of the potential */
    double *size;       /* of the forces that meet, limit_i + |r_i| + sum_j |S_ij v_j| */
    double *step;       /* of the slipping contacts, in the order of the factor */
    double potential;
    sm_slipping slipping;
} sm_descent;

/* What friction cannot hold of a force at velocity v. */
SM_INLINE double sm_unbalanced(double limit, double v, double force) {
    if (v != 0.0) return force - copysign(limit, v);
    return fabs(force) <= limit ? 0.0 : force - copysign(limit, force);
}

/* To half of the tolerance: `size` has S_ii v_i too, which is no more than the others together. */
SM_INLINE int sm_descent_balanced(const sm_descent *m, int i) {
    return fabs(m->unbalanced[i]) <= 0.5 * SM_STAGE_TOLERANCE * m->size[i];
}

/* Forces and potential at the velocities; whether the forces balance. */
SM_INLINE int sm_descent_balance(const sm_stepper *s, sm_descent *m, const int lanes,
                                 const double *r) {
    const int n = m->contacts;
    double *restrict force = m->unbalanced, *restrict size = m->size;
    for (int i = 0; i < n; i++) {
        force[i] = r[i * lanes];
        size[i] = s->laws[i].limit + fabs(force[i]) + 1e-300;
    }
    for (int j = 0; j < n; j++) {
        const double v_j = m->v[j], *restrict column = s->matrix + (size_t)j * (size_t)n;
        if (v_j == 0.0) continue;
        SM_SIMD
        for (int i = 0; i < n; i++) {
            const double from_j = column[i] * v_j;
            force[i] -= from_j;
            size[i] += fabs(from_j);
        }
    }
    int balanced = 1;
    m->potential = 0.0;
    for (int i = 0; i < n; i++) {
        m->potential += s->laws[i].limit * fabs(m->v[i])
                        - 0.5 * m->v[i] * (r[i * lanes] + force[i]);
        force[i] = sm_unbalanced(s->laws[i].limit, m->v[i], force[i]);
        balanced &= sm_descent_balanced(m, i);
    }
    return balanced;
}

/* The contacts that slip from now on: those that do, and if `more` those that friction cannot
 * hold. */
SM_INLINE void sm_descent_choose(const sm_stepper *s, const sm_descent *m, int more) {
    const sm_slipping *a = &m->slipping;
    for (int i = m->contacts - 1; i >= 0; i--) {
        const int slips = m->v[i] != 0.0 || (more && !sm_descent_balanced(m, i));
        if (slips && a->place[i] == 0) sm_slipping_add(a, m->contacts, s->matrix, i);
        if (!slips && a->place[i] > 0) sm_slipping_remove(a, m->contacts, i);
    }
}

/* The step to the minimum of this piece. Contacts that would start against the force on them
 * stick; one at least does not. */
SM_INLINE void sm_descent_aim(const sm_descent *m) {
    const sm_slipping *a = &m->slipping;
    for (int stays = 1; stays;) {
        stays = 0;
        for (int row = 0; row < *a->count; row++) m->step[row] = m->unbalanced[a->order[row]];
        sm_slipping_divide(a, m->contacts, m->step);
        for (int row = *a->count - 1; row >= 0; row--) {
            const int i = a->order[row];
            if (m->v[i] != 0.0 || !(m->step[row] * m->unbalanced[i] < 0.0)) continue;
            sm_slipping_remove(a, m->contacts, i);
            stays = 1;
        }
    }
}

/* Part of the step where a contact's velocity is zero; infinite if it never is, and without
 * friction, where that is no kink. */
SM_INLINE double sm_descent_kink(const sm_stepper *s, const sm_descent *m, int row) {
    const int i = m->slipping.order[row];
    const int stops = m->v[i] * m->step[row] < 0.0 && s->laws[i].limit > 0.0;
    return stops ? -m->v[i] / m->step[row] : INFINITY;
}

/* Part of the step up to the last kink that the potential falls towards. Along the step its slope
 * is (part - 1) work, and at a kink it gains 2 limit |step|. */
SM_INLINE double sm_descent_part(const sm_stepper *s, const sm_descent *m, double work) {
    const sm_slipping *a = &m->slipping;
    double part = 1.0, lowest = 1.0;
    for (int last = -1;;) {
        int next = -1;
        double at = lowest;
        for (int row = 0; row < *a->count; row++) {
            const double kink = sm_descent_kink(s, m, row);
            const int passed = last >= 0 && (kink < part || (kink == part && row <= last));
            if (passed || kink >= at) continue;
            at = kink;
            next = row;
        }
        if (next < 0) return part;
        part = at;
        last = next;
        lowest -= 2.0 * s->laws[a->order[next]].limit * fabs(m->step[next]) / work;
    }
}

/* All of the step, but contacts whose velocity would pass through zero stick; whether some do. */
SM_INLINE int sm_descent_leap(const sm_stepper *s, const sm_descent *m) {
    const sm_slipping *a = &m->slipping;
    int stuck = 0;
    memcpy(m->before, m->v, (size_t)m->contacts * sizeof(double));
    for (int row = 0; row < *a->count; row++) {
        const int i = a->order[row], sticks = sm_descent_kink(s, m, row) <= 1.0;
        m->v[i] = sticks ? 0.0 : m->v[i] + m->step[row];
        stuck |= sticks;
    }
    return stuck;
}

/* The same step as far as the potential falls. */
SM_INLINE void sm_descent_retreat(const sm_stepper *s, const sm_descent *m, double work) {
    const sm_slipping *a = &m->slipping;
    memcpy(m->v, m->before, (size_t)m->contacts * sizeof(double));
    const double part = sm_descent_part(s, m, work);
    for (int row = 0; row < *a->count; row++) {
        double *v = m->v + a->order[row];
        const double moved = *v + part * m->step[row];
        *v = fabs(moved) > 1e-15 * fabs(*v) ? moved : 0.0; /* a kink is at zero */
    }
}

SM_INLINE sm_status sm_active_set_solve(const sm_stepper *s, sm_descent *m, const int lanes,
                               const double *r) {
    const sm_slipping *a = &m->slipping;
    double work = 0.0, highest = INFINITY;
    int stuck = 0;
    for (int k = 0; k < 100 * m->contacts; k++) { /* many times what was ever seen */
        if (sm_descent_balance(s, m, lanes, r)) return SM_OK;
        if (!isfinite(m->potential)) return SM_NOT_FINITE;
        if (stuck && !(m->potential < highest)) {
            sm_descent_retreat(s, m, work);
            highest = INFINITY;
            continue;
        }
        if (k % SM_DESCENT_FRESH == SM_DESCENT_FRESH - 1) sm_slipping_forget(a, m->contacts);
        sm_descent_choose(s, m, !stuck);
        sm_descent_aim(m);
        work = 0.0;
        for (int row = 0; row < *a->count; row++)
            work += m->step[row] * m->unbalanced[a->order[row]];
        highest = m->potential;
        stuck = sm_descent_leap(s, m);
    }
    return SM_NOT_CONVERGED;
}

/* The lanes where `norm` of the residual is too large, from their velocities m->v. */
SM_INLINE sm_status sm_active_set_all(const int lanes, const sm_stepper *s, sm_lanes *m,
                                   const double *norm) {
    const int n = s->contacts;
    if (m->factored != s->matrix) sm_lanes_forget(m, n, lanes);
    m->factored = s->matrix;
    for (int l = 0; l < lanes; l++) {
        if (norm[l] <= SM_STAGE_TOLERANCE) continue;
        sm_descent d = {.contacts = n,
                        .v = m->conjugate,
                        .unbalanced = m->conjugate + n,
                        .size = m->conjugate + 2 * n,
                        .before = m->residual,
                        .step = m->packed,
                        .slipping = sm_slipping_of(n, l, m->slipping, m->factor)};
        for (int i = 0; i < n; i++) d.v[i] = norm[l] < INFINITY ? m->v[i * lanes + l] : 0.0;
        const sm_status status = sm_active_set_solve(s, &d, lanes, m->r + l);
        if (status != SM_OK) return status;
        for (int i = 0; i < n; i++) m->v[i * lanes + l] = d.v[i];
    }
    return SM_OK;
}

#endif
