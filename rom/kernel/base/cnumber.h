/* Complex numbers as a structure, because some compilers have no complex type of C99; and phasors
 * of the harmonics (n, m), eq. (14) (harmonics.c). All rooms use them. */
#ifndef SLIPMODE_CNUMBER_H
#define SLIPMODE_CNUMBER_H

#include "base/lanes.h"
#include "slipmode.h"

typedef struct {
    double re, im;
} sm_complex;

/* Returns re + i im. */
static inline sm_complex sm_cx(double re, double im) {
    const sm_complex z = {re, im};
    return z;
}
/* Returns the complex number with the parts (re, im) of an array. */
static inline sm_complex sm_pair(const double *values) { return sm_cx(values[0], values[1]); }
/* Returns exp(i angle). */
static inline sm_complex sm_unit(double angle) { return sm_cx(cos(angle), sin(angle)); }
/* Returns a + b. */
static inline sm_complex sm_cadd(sm_complex a, sm_complex b) {
    return sm_cx(a.re + b.re, a.im + b.im);
}
/* Returns a - b. */
static inline sm_complex sm_csub(sm_complex a, sm_complex b) {
    return sm_cx(a.re - b.re, a.im - b.im);
}
/* Returns a b. */
static inline sm_complex sm_cmul(sm_complex a, sm_complex b) {
    return sm_cx(a.re * b.re - a.im * b.im, a.re * b.im + a.im * b.re);
}
/* Returns s a for a real factor s. */
static inline sm_complex sm_cscale(sm_complex a, double s) { return sm_cx(a.re * s, a.im * s); }
/* Returns the complex conjugate. */
static inline sm_complex sm_conj(sm_complex a) { return sm_cx(a.re, -a.im); }
/* Returns |a|^2. */
static inline double sm_cabs2(sm_complex a) { return a.re * a.re + a.im * a.im; }
/* Returns a / b. */
static inline sm_complex sm_cdiv(sm_complex a, sm_complex b) {
    return sm_cscale(sm_cmul(a, sm_conj(b)), 1.0 / sm_cabs2(b));
}

/* One complex number per mode, real parts next to each other: the compiler turns a loop over modes
 * into one vector operation. In hot loops it is never copied as a whole after one mode was written:
 * a load that is wider than the store before it waits until the store is complete. */
typedef struct {
    double re[SM_MODES], im[SM_MODES];
} sm_modal;

/* Returns the number of mode j. */
SM_INLINE sm_complex sm_of(const sm_modal *z, int j) { return sm_cx(z->re[j], z->im[j]); }

/* Sets the number of mode j. */
SM_INLINE void sm_put(sm_modal *z, int j, sm_complex value) {
    z->re[j] = value.re;
    z->im[j] = value.im;
}

/* Phasors exp(i angle), as a row of real parts and a row of imaginary parts. */

/* Multiplies phasors by `count` others. */
SM_INLINE void sm_turn(size_t count, double *restrict re, double *restrict im,
                       const double *restrict by_re, const double *restrict by_im) {
    SM_SIMD
    for (size_t k = 0; k < count; k++) {
        const double real = re[k] * by_re[k] - im[k] * by_im[k];
        im[k] = re[k] * by_im[k] + im[k] * by_re[k];
        re[k] = real;
    }
}

/* Computes the powers 0, 2, 3, ... of phasors z: `power` (powers, 2, count) has z as power 1. */
void sm_powers(size_t count, size_t powers, double *power);

/* Harmonics (n, m) of two carriers. */

#define SM_MOST_ORDERS 512 /* limit of the harmonics of a sum: their phasors are on the stack */
#define SM_HIGHEST_ORDER 128 /* limit of |n| and |m|: powers are on the stack; tables have up to 15 */

/* Checks that there are at most SM_MOST_ORDERS harmonics, and that |n| and |m| are at most
 * SM_HIGHEST_ORDER. */
sm_status sm_orders_check(int count, const int32_t *orders);

/* Computes exp(i (n theta_A + m theta_B)) of each harmonic from carrier = exp(i theta_A),
 * exp(i theta_B). */
void sm_harmonic_phasors(int count, const int32_t *orders, const sm_complex carrier[SM_MODES],
                         double *re, double *im);

#endif
