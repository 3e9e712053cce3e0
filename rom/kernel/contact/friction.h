/* Friction laws as resolvents: v(y) that solves s v + g(v) = y for one contact.
 *
 * y is the well-scaled unknown of the contact problem: v(y) is Lipschitz with constant 1/s
 * whatever the regularisation, so exact Coulomb friction is the limit alpha = 0 of the same solve.
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
} sm_resolvent;

sm_resolvent sm_resolvent_make(int32_t law, double s, double limit, double alpha);

/* tanh w, where e = exp(-2 |w|) and inv = 1 / (1 + e): to rounding also where w is small. */
SM_INLINE double sm_tanh_from(double w, double e, double inv) {
    const double size = fabs(w);
    const double small = size * (1.0 - size * size * (1.0 / 3.0));
    return copysign(size < 1e-4 ? small : (1.0 - e) * inv, w);
}

/* The w >= 0 where c w + tanh w = eta >= 0 lies between these. */
SM_INLINE double sm_tanh_low(const sm_resolvent *f, double eta) {
    const double slip_bound = (eta - 1.0) * f->slip, stick_bound = eta * f->stick;
    return slip_bound > stick_bound ? slip_bound : stick_bound;
}
SM_INLINE double sm_tanh_high(const sm_resolvent *f, double eta) { return eta * f->slip; }

/* About the w >= 0 where c w + tanh w = eta >= 0. */
SM_INLINE double sm_tanh_guess(const sm_resolvent *f, double eta) {
    const double knee = f->knee, delta = 1.0 - eta;
    /* 1 - tanh w, joined smoothly between stick (delta) and slip (0) */
    double gap = 0.5 * (delta + sqrt(delta * delta + 4.0 * knee * knee));
    gap = gap > 1.999 ? 1.999 : gap;
    const double from_stick = 0.5 * sm_log_rough((2.0 - gap) / gap);
    const double from_slip = (gap - delta) * f->slip;
    const double w = delta > 0.0 ? from_stick : from_slip;
    const double low = sm_tanh_low(f, eta), high = sm_tanh_high(f, eta);
    const double raised = w < low ? low : w;
    return raised > high ? high : raised;
}

/* s v + limit tanh(v / alpha) = y, by Halley's method inside a bracket; d = dv/dy.
 * In scaled form F(w) = c w + tanh w - eta is increasing and concave for w > 0, so from the lower
 * end of the bracket the iteration converges whatever the data. */
SM_INLINE void sm_resolve_tanh(const int lanes, const sm_resolvent *f, const double *restrict y,
                               double *restrict v, double *restrict d) {
    const double c = f->c, inv_limit = 1.0 / f->limit;
    double eta[SM_LANES], w[SM_LANES], low[SM_LANES], high[SM_LANES], slope[SM_LANES];
    SM_SIMD
    for (int l = 0; l < lanes; l++) {
        const double e = fabs(y[l]) * inv_limit;
        low[l] = sm_tanh_low(f, e);
        high[l] = sm_tanh_high(f, e);
        w[l] = sm_tanh_guess(f, e);
        eta[l] = e;
    }
    for (int iteration = 0; iteration < 60; iteration++) {
        double worst = 0.0;
        SM_SIMD_MAX(worst)
        for (int l = 0; l < lanes; l++) {
            const double e = sm_exp_negative(-2.0 * w[l]);
            const double inv = 1.0 / (1.0 + e);
            const double t = sm_tanh_from(w[l], e, inv), sech2 = 4.0 * e * inv * inv;
            const double value = c * w[l] + t - eta[l];
            const double first = c + sech2, second = -2.0 * t * sech2;
            low[l] = value < 0.0 ? w[l] : low[l];
            high[l] = value < 0.0 ? high[l] : w[l];
            double next =
                w[l] - 2.0 * value * first / (2.0 * first * first - value * second);
            next = next < low[l] ? low[l] : next;
            next = next > high[l] ? high[l] : next;
            const double change = fabs(next - w[l]) / (1.0 + w[l]);
            worst = change > worst ? change : worst;
            w[l] = next;
            slope[l] = first;
        }
        if (worst < 1e-5) break; /* cubic convergence: the next change is of the order 1e-15 */
    }
    const double scale = f->alpha * inv_limit;
    SM_SIMD
    for (int l = 0; l < lanes; l++) {
        v[l] = copysign(f->alpha * w[l], y[l]);
        d[l] = scale / slope[l];
    }
}

/* s v + limit sign(v) = y, set-valued at v = 0; d = dv/dy. */
SM_INLINE void sm_resolve_coulomb(const int lanes, const sm_resolvent *f,
                                  const double *restrict y, double *restrict v,
                                  double *restrict d) {
    const double inv_s = 1.0 / f->s, limit = f->limit;
    SM_SIMD
    for (int l = 0; l < lanes; l++) {
        const double excess = fabs(y[l]) - limit;
        v[l] = excess > 0.0 ? copysign(excess * inv_s, y[l]) : 0.0;
        d[l] = excess > 0.0 ? inv_s : 0.0;
    }
}

SM_INLINE void sm_resolve(const int lanes, const sm_resolvent *f, const double *restrict y,
                          double *restrict v, double *restrict d) {
    if (f->law == SM_TANH && f->limit > 0.0)
        sm_resolve_tanh(lanes, f, y, v, d);
    else
        sm_resolve_coulomb(lanes, f, y, v, d); /* also the frictionless contact, limit = 0 */
}

#endif
