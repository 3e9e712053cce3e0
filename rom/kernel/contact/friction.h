/* Friction laws, eq. (28): the force g(v) of a contact and its slope, and the velocity v(y) of a
 * contact on its own that solves s v + g(v) = y.
 *
 * Coulomb friction is the limit alpha = 0 of tanh friction: its slope is infinite where the contact
 * sticks. stage/newton.h calls these functions for each contact.
 */
#ifndef SLIPMODE_FRICTION_H
#define SLIPMODE_FRICTION_H

#include "base/lanes.h"
#include "slipmode.h"

typedef struct {
    int32_t law;
    double s;     /* > 0, diagonal of the step matrix [N s/m] */
    double limit; /* mu N [N] */
    double alpha; /* [m/s] */
    double c;     /* s alpha / limit: scaled form c w + tanh w = eta */
    double slip, stick; /* 1 / c and 1 / (1 + c): dw / deta where it slips, and where it sticks */
    double knee;  /* 1 - tanh w at eta = 1: width of the stick-slip transition */
    double per_alpha, steepest, per_steepest; /* 1 / alpha, limit / alpha; 0: no tanh */
    double per_limit; /* 1 / limit; 0: without friction */
} sm_resolvent;

sm_resolvent sm_resolvent_make(int32_t law, double s, double limit, double alpha);

/* tanh w, where e = exp(-2 |w|) and inv = 1 / (1 + e): to rounding also where w is small. */
SM_INLINE double sm_tanh_from(double w, double e, double inv) {
    const double size = fabs(w);
    const double small = size * (1.0 - size * size * (1.0 / 3.0));
    return copysign(size < 1e-4 ? small : (1.0 - e) * inv, w);
}

/* Returns an estimate of the w >= 0 where c w + tanh w = eta >= 0, between its bounds. */
SM_INLINE double sm_tanh_guess(const sm_resolvent *f, double eta) {
    const double knee = f->knee, delta = 1.0 - eta;
    /* 1 - tanh w, joined smoothly between stick (delta) and slip (0) */
    double gap = 0.5 * (delta + sqrt(delta * delta + 4.0 * knee * knee));
    gap = gap > 1.999 ? 1.999 : gap;
    const double from_stick = 0.5 * sm_log_rough((2.0 - gap) / gap);
    const double from_slip = (gap - delta) * f->slip;
    const double w = delta > 0.0 ? from_stick : from_slip;
    const double slip_bound = (eta - 1.0) * f->slip, stick_bound = eta * f->stick;
    const double low = slip_bound > stick_bound ? slip_bound : stick_bound, high = eta * f->slip;
    const double raised = w < low ? low : w;
    return raised > high ? high : raised;
}

/* About the v where s v + g(v) = y, in lanes: exactly under Coulomb friction, and without friction. */
SM_INLINE void sm_velocity_guess(const int lanes, const sm_resolvent *f,
                                 const double *restrict y, double *restrict v) {
    const double limit = f->limit, per_limit = f->per_limit, per_s = 1.0 / f->s;
    if (f->per_alpha > 0.0) {
        SM_SIMD
        for (int l = 0; l < lanes; l++)
            v[l] = copysign(f->alpha * sm_tanh_guess(f, fabs(y[l]) * per_limit), y[l]);
        return;
    }
    SM_SIMD
    for (int l = 0; l < lanes; l++) {
        const double excess = fabs(y[l]) - limit;
        v[l] = excess > 0.0 ? copysign(excess * per_s, y[l]) : 0.0;
    }
}

/* Friction g at velocities v and its slope dg/dv, in lanes. `load` is the force without friction: a
 * Coulomb contact at rest resists it up to the limit, and its slope is infinite up to there. */
SM_INLINE void sm_friction_force(const int lanes, const sm_resolvent *f,
                                 const double *restrict v, const double *restrict load,
                                 double *restrict g, double *restrict slope) {
    const double limit = f->limit, per_alpha = f->per_alpha, steepest = 4.0 * f->steepest;
    if (per_alpha > 0.0) {
        SM_SIMD
        for (int l = 0; l < lanes; l++) {
            const double w = v[l] * per_alpha;
            const double e = sm_exp_negative(-2.0 * fabs(w)), inv = 1.0 / (1.0 + e);
            g[l] = limit * sm_tanh_from(w, e, inv);
            slope[l] = steepest * e * inv * inv;
        }
        return;
    }
    SM_SIMD
    for (int l = 0; l < lanes; l++) { /* also the frictionless contact, limit = 0 */
        const double at_rest = fabs(load[l]) <= limit ? load[l] : copysign(limit, load[l]);
        g[l] = v[l] == 0.0 ? at_rest : copysign(limit, v[l]);
        slope[l] = v[l] == 0.0 && fabs(load[l]) <= limit && limit > 0.0 ? INFINITY : 0.0;
    }
}

#endif
