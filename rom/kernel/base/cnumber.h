/* Complex numbers as a struct: compilers without C99 complex arithmetic can build the core. */
#ifndef SLIPMODE_CNUMBER_H
#define SLIPMODE_CNUMBER_H

#include "base/lanes.h"
#include "slipmode.h"

typedef struct {
    double re, im;
} sm_complex;

static inline sm_complex sm_cx(double re, double im) {
    const sm_complex z = {re, im};
    return z;
}
/* From (re, im) in an array. */
static inline sm_complex sm_pair(const double *values) { return sm_cx(values[0], values[1]); }
/* exp(i angle) */
static inline sm_complex sm_unit(double angle) { return sm_cx(cos(angle), sin(angle)); }
static inline sm_complex sm_cadd(sm_complex a, sm_complex b) {
    return sm_cx(a.re + b.re, a.im + b.im);
}
static inline sm_complex sm_csub(sm_complex a, sm_complex b) {
    return sm_cx(a.re - b.re, a.im - b.im);
}
static inline sm_complex sm_cmul(sm_complex a, sm_complex b) {
    return sm_cx(a.re * b.re - a.im * b.im, a.re * b.im + a.im * b.re);
}
static inline sm_complex sm_cscale(sm_complex a, double s) { return sm_cx(a.re * s, a.im * s); }
static inline sm_complex sm_conj(sm_complex a) { return sm_cx(a.re, -a.im); }
static inline double sm_cabs2(sm_complex a) { return a.re * a.re + a.im * a.im; }
static inline sm_complex sm_cdiv(sm_complex a, sm_complex b) {
    return sm_cscale(sm_cmul(a, sm_conj(b)), 1.0 / sm_cabs2(b));
}
/* z^n for a number on the unit circle, by squares; n < 0 by the conjugate. */
static inline sm_complex sm_unit_power(sm_complex z, int n) {
    unsigned left = n < 0 ? 0u - (unsigned)n : (unsigned)n;
    sm_complex power = n < 0 ? sm_conj(z) : z;
    sm_complex result = left & 1u ? power : sm_cx(1.0, 0.0);
    while (left >>= 1) {
        power = sm_cmul(power, power);
        if (left & 1u) result = sm_cmul(result, power);
    }
    return result;
}

/* A complex number of each mode, side by side: loops over modes are one operation on both.
 *
 * Nothing of the sort is copied as a whole or put together from one mode after the other on the
 * hot path: loads that are wider than the stores before them wait for these. */

typedef struct {
    double re[SM_MODES], im[SM_MODES];
} sm_modal;

SM_INLINE sm_complex sm_of(const sm_modal *z, int j) { return sm_cx(z->re[j], z->im[j]); }

SM_INLINE void sm_put(sm_modal *z, int j, sm_complex value) {
    z->re[j] = value.re;
    z->im[j] = value.im;
}

/* Harmonics (n, m) of two carriers. */

#define SM_MOST_ORDERS 512 /* harmonics of one sum */

/* At most SM_MOST_ORDERS of them, each |n| and |m| small enough for what follows. */
sm_status sm_orders_check(int count, const int32_t *orders);

/* exp(i (n theta_A + m theta_B)) of each harmonic. */
void sm_harmonic_phasors(int count, const int32_t *orders, const sm_complex carrier[SM_MODES],
                         double *re, double *im);

#endif
