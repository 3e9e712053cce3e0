/* Products of a symmetric matrix with lane arrays. Independent partial sums stay in registers, so
 * that no addition waits for the result of the one before. Contact steps call them (contact/). */
#ifndef SLIPMODE_PRODUCTS_H
#define SLIPMODE_PRODUCTS_H

#include "base/lanes.h"

#define SM_SUMS (4 * SM_LANES) /* partial sums at the same time, which fit in the registers */

/* Computes to = S x for `rows` (a literal) successive rows of S. `column` points at their entries
 * in the first column, which are next to each other in memory because S is symmetric. */
SM_INLINE void sm_rows_times(const int rows, const int n, const int lanes,
                             const double *restrict column, const double *restrict x,
                             double *restrict to) {
    double sum[SM_SUMS];
    for (int k = 0; k < rows * lanes; k++) sum[k] = 0.0;
    for (int j = 0; j < n; j++, column += n, x += lanes)
        if (lanes == 1) {
            SM_SIMD
            for (int k = 0; k < rows; k++) sum[k] += column[k] * x[0];
        } else {
            for (int k = 0; k < rows; k++) {
                SM_SIMD
                for (int l = 0; l < lanes; l++) sum[k * lanes + l] += column[k] * x[l];
            }
        }
    for (int k = 0; k < rows * lanes; k++) to[k] = sum[k];
}

/* Computes to = S x. */
SM_INLINE void sm_times(const int n, const int lanes, const double *restrict matrix,
                        const double *restrict x, double *restrict to) {
    const int rows = lanes == 1 ? 16 : SM_SUMS / SM_LANES;
    int i = 0;
    for (; i + rows <= n; i += rows)
        sm_rows_times(rows, n, lanes, matrix + i, x, to + i * lanes);
    for (; i < n; i++) sm_rows_times(1, n, lanes, matrix + i, x, to + i * lanes);
}

/* Computes to = sum_j row_j x_j in each lane. */
SM_INLINE void sm_row_times(const int n, const int lanes, const double *restrict row,
                            const double *restrict x, double *restrict to) {
    const int terms = lanes == 1 ? 16 : 2;
    double sum[2 * SM_LANES];
    for (int k = 0; k < terms * lanes; k++) sum[k] = 0.0;
    int j = 0;
    for (; j + terms <= n; j += terms, row += terms, x += terms * lanes)
        if (lanes == 1) {
            SM_SIMD
            for (int k = 0; k < terms; k++) sum[k] += row[k] * x[k];
        } else {
            for (int k = 0; k < terms; k++) {
                SM_SIMD
                for (int l = 0; l < lanes; l++) sum[k * lanes + l] += row[k] * x[k * lanes + l];
            }
        }
    for (; j < n; j++, row++, x += lanes) {
        SM_SIMD
        for (int l = 0; l < lanes; l++) sum[l] += row[0] * x[l];
    }
    for (int l = 0; l < lanes; l++) {
        to[l] = sum[l];
        for (int k = 1; k < terms; k++) to[l] += sum[k * lanes + l];
    }
}

#endif
