/* Dense Cholesky factor of J = S + diag(slope) in lanes, and J x = b by it.
 *
 * J = U^T D^-1 U, with rows U_i from the diagonal on and pivots D. A contact that sticks under Coulomb
 * friction has an infinite slope and the inverse pivot 0: it does not move, and the factor is the one
 * of the contacts that slip. base/dense.h is for one matrix: here the matrices of all lanes
 * are factorised in one vector operation, and one lane keeps the rows that have not changed. Called by
 * newton.h.
 */
#ifndef SLIPMODE_FACTOR_H
#define SLIPMODE_FACTOR_H

#include "base/check.h"
#include "base/products.h"

/* Subtracts w_0 U_0 + w_1 U_1, of two rows before, from a row of `count` columns. */
SM_INLINE void sm_subtract_rows(const int lanes, int count, const double *restrict w,
                            const double *restrict U_0, const double *restrict U_1,
                            double *restrict row) {
    if (lanes == 1) {
        SM_SIMD
        for (int j = 0; j < count; j++) row[j] -= w[0] * U_0[j] + w[1] * U_1[j];
        return;
    }
    for (int j = 0; j < count * lanes; j += lanes) {
        SM_SIMD
        for (int l = 0; l < lanes; l++)
            row[j + l] = (row[j + l] - w[l] * U_0[j + l]) - w[lanes + l] * U_1[j + l];
    }
}

/* Computes the factor f (N_c, N_c, lanes) from row `first` on; the rows before are up to date. Its
 * diagonal has the inverse pivots. */
SM_INLINE void sm_factorise(const int n, const int lanes, const double *restrict matrix,
                            const double *restrict slope, int first, double *restrict f) {
    for (int i = first; i < n; i++) {
        const double s_ii = matrix[(size_t)i * n + i];
        double *restrict row = f + (size_t)i * n * lanes, *restrict pivot = row + i * lanes;
        if (lanes == 1 && !(slope[i] < INFINITY)) {
            pivot[0] = 0.0;
            continue;
        }
        for (int j = i; j < n; j++)
            for (int l = 0; l < lanes; l++) row[j * lanes + l] = matrix[(size_t)i * n + j];
        for (int l = 0; l < lanes; l++) pivot[l] += slope[i * lanes + l];
        for (int k = 0; k < i; k += 2) {
            const double *restrict U = f + (size_t)k * n * lanes;
            const double *restrict next = k + 1 < i ? U + (size_t)n * lanes : U;
            double w[2 * SM_LANES] = {0.0};
            SM_SIMD
            for (int l = 0; l < lanes; l++) w[l] = U[i * lanes + l] * U[k * lanes + l];
            if (k + 1 < i) {
                SM_SIMD
                for (int l = 0; l < lanes; l++)
                    w[lanes + l] = next[i * lanes + l] * next[(k + 1) * lanes + l];
            }
            /* contacts that stick; for two contacts a branch costs more than it saves */
            if (lanes == 1 && n > 2 && w[0] == 0.0 && w[1] == 0.0) continue;
            sm_subtract_rows(lanes, n - i, w, U + i * lanes, next + i * lanes, row + i * lanes);
        }
        SM_SIMD
        for (int l = 0; l < lanes; l++) {
            const double least = SM_ROUNDING * s_ii; /* the pivot of a singular S is rounding */
            pivot[l] = 1.0 / (pivot[l] < least ? least : pivot[l]);
        }
    }
}

/* x = J^-1 x */
SM_INLINE void sm_divide(const int n, const int lanes, const double *restrict f,
                         double *restrict x) {
    for (int k = 0; k < n; k++) {
        const double *restrict U = f + (size_t)k * n * lanes;
        double *restrict x_k = x + k * lanes;
        SM_SIMD
        for (int l = 0; l < lanes; l++) x_k[l] *= U[k * lanes + l];
        if (lanes == 1) {
            const double by = x_k[0];
            if (n > 2 && by == 0.0) continue;
            SM_SIMD
            for (int j = k + 1; j < n; j++) x[j] -= U[j] * by;
        } else {
            for (int j = k + 1; j < n; j++) {
                SM_SIMD
                for (int l = 0; l < lanes; l++) x[j * lanes + l] -= U[j * lanes + l] * x_k[l];
            }
        }
    }
    for (int k = n - 2; k >= 0; k--) {
        const double *restrict U = f + (size_t)k * n * lanes;
        double sum[SM_LANES] = {0.0};
        if (lanes == 1) {
            double one = 0.0;
            if (n > 2 && U[k] == 0.0) continue;
            SM_SIMD_SUM(one)
            for (int j = k + 1; j < n; j++) one += U[j] * x[j];
            sum[0] = one;
        } else {
            for (int j = k + 1; j < n; j++) {
                SM_SIMD
                for (int l = 0; l < lanes; l++) sum[l] += U[j * lanes + l] * x[j * lanes + l];
            }
        }
        SM_SIMD
        for (int l = 0; l < lanes; l++) x[k * lanes + l] -= U[k * lanes + l] * sum[l];
    }
}

#endif
