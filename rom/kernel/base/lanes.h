/* Lanes: up to SM_LANES independent contact problems side by side, one per vector element.
 * Lane arrays are [contact][lane]. Loops over lanes have no calls and no branches that differ
 * between lanes, so that the compiler can vectorise them. `lanes` is a literal (1, SM_FEW_LANES or
 * SM_LANES) in the outermost callers, and each loop is compiled for its width. Contact steps and
 * the torus use lanes. */
#ifndef SLIPMODE_LANES_H
#define SLIPMODE_LANES_H

#include <math.h>
#include <stdint.h>
#include <string.h>

#define SM_LANES 16 /* two of the widest vectors, whose operations overlap */
#define SM_FEW_LANES SM_VECTOR /* if all problems fit into 8 lanes: two thirds of the time of 16 */
#define SM_VECTOR 8 /* doubles of the widest vectors, and of a cache line: 64 bytes */
#define SM_SHORT_VECTOR 4 /* doubles of the most common vectors, for rows of one lane */

#if defined(__GNUC__)
#define SM_INLINE static inline __attribute__((always_inline))
#else
#define SM_INLINE static inline
#endif

/* One binary for every x86-64: the loader picks the widest clone the processor has. */
#if defined(SM_CLONES)
#define SM_HOT __attribute__((target_clones("arch=x86-64-v4", "arch=x86-64-v3", "default")))
/* for functions of one lane, which the widest vectors would slow down by a fifth */
#define SM_HOT_ONE __attribute__((target_clones("arch=x86-64-v3", "default")))
#else
#define SM_HOT
#define SM_HOT_ONE
#endif

#if defined(SM_OPENMP_SIMD)
#define SM_SIMD _Pragma("omp simd")
#define SM_SIMD_MAX(variable) SM_PRAGMA(omp simd reduction(max : variable))
#define SM_SIMD_SUM(...) SM_PRAGMA(omp simd reduction(+ : __VA_ARGS__))
#define SM_PRAGMA(...) _Pragma(#__VA_ARGS__)
#else
#define SM_SIMD
#define SM_SIMD_MAX(variable)
#define SM_SIMD_SUM(...)
#endif

/* Returns exp(x) for x <= 0 as 2^k exp(r), |r| <= ln(2) / 2, with a relative error below 6e-16. For
 * x < -700 it returns exp(-700), about 1e-304: 2^k must not be denormal. */
SM_INLINE double sm_exp_negative(double x) {
    const double shifter = 6755399441055744.0; /* 1.5 * 2^52: rounds to an integer when added */
    x = x < -700.0 ? -700.0 : x;
    const double shifted = x * 1.4426950408889634 + shifter; /* x / ln(2) */
    const double k = shifted - shifter;
    /* ln(2) as a sum, whose first term has 33 bits: its product with k is exact */
    const double r = (x - k * 6.93147180369123816490e-01) - k * 1.90821492927058770002e-10;
    /* the series up to r^11, in three parts that the processor computes at the same time */
    const double r2 = r * r, r4 = r2 * r2;
    const double low = (1.0 + r) + r2 * (0.5 + r * (1.0 / 6.0));
    const double middle = (1.0 / 24.0 + r * (1.0 / 120.0))
                          + r2 * (1.0 / 720.0 + r * (1.0 / 5040.0));
    const double high = (1.0 / 40320.0 + r * (1.0 / 362880.0))
                        + r2 * (1.0 / 3628800.0 + r * (1.0 / 39916800.0));
    const double p = low + r4 * (middle + r4 * high);
    uint64_t bits;
    memcpy(&bits, &shifted, sizeof bits);
    bits = (bits + 1023u) << 52;
    double scale;
    memcpy(&scale, &bits, sizeof scale);
    return p * scale;
}

/* Returns log(x) for x > 0 with an absolute error of about 1e-3, for initial guesses. */
SM_INLINE double sm_log_rough(double x) {
    uint64_t bits;
    memcpy(&bits, &x, sizeof bits);
    /* exponent as a double without an integer conversion: 2^52 + (bits >> 52), then subtract */
    uint64_t exponent_bits = (bits >> 52) | 0x4330000000000000u;
    double exponent;
    memcpy(&exponent, &exponent_bits, sizeof exponent);
    exponent -= 4503599627370496.0 + 1023.0;
    bits = (bits & 0x000fffffffffffffu) | 0x3ff0000000000000u;
    double m;
    memcpy(&m, &bits, sizeof m);
    /* minimax cubic of log2(m), 1 <= m < 2 */
    const double log2_m = ((0.15824870 * m - 1.05187502) * m + 3.04788415) * m - 2.15362070;
    return (exponent + log2_m) * 0.6931471805599453;
}

#endif
