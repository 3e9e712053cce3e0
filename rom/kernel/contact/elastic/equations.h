/* Gauss's elimination, with row exchanges or of symmetric matrices; products with the flexibility. */
#ifndef SLIPMODE_EQUATIONS_H
#define SLIPMODE_EQUATIONS_H

#include "base/lanes.h"

#define SM_MANY_EQUATIONS 24
#define SM_PANEL 4 /* columns that are eliminated together */

/* to (n) -= R[:, column] by in rows of R (n, n), symmetric, side by side, for a sum waits for itself
 * alone; how many rows that is. */
size_t sm_subtract_many(size_t n, const double *R, const int32_t *column, size_t columns,
                        const double *by, double *to);

/* The same of all rows. */
SM_INLINE void sm_subtract_columns(size_t n, const double *R, const int32_t *column,
                                   size_t columns, const double *by, double *to) {
    if (columns == 0) return;
    const size_t done = n < SM_VECTOR ? 0 : sm_subtract_many(n, R, column, columns, by, to);
    for (size_t k = 0; k < columns && done < n; k++) {
        const double *restrict from = R + (size_t)column[k] * n;
        for (size_t i = done; i < n; i++) to[i] -= from[i] * by[k];
    }
}

SM_INLINE void sm_exchange(double *a, double *b, size_t count) {
    for (size_t k = 0; k < count; k++) {
        const double t = a[k];
        a[k] = b[k];
        b[k] = t;
    }
}

/* Columns from c on are eliminated, as far as `end` at once; factors stay where zeros would be. */
SM_INLINE int sm_eliminate_panel(size_t n, size_t c, size_t end, double *matrix, double *right) {
    for (const size_t start = c; c < end; c++) {
        double *const from = matrix + c * n;
        size_t pivot = c;
        for (size_t r = c + 1; r < n; r++)
            if (fabs(matrix[r * n + c]) > fabs(matrix[pivot * n + c])) pivot = r;
        if (!(fabs(matrix[pivot * n + c]) > 0.0)) return 0;
        if (pivot != c) {
            sm_exchange(from + start, matrix + pivot * n + start, n - start);
            sm_exchange(right + c, right + pivot, 1);
        }
        for (size_t r = c + 1; r < n; r++) {
            double *restrict row = matrix + r * n;
            const double factor = row[c] = row[c] / from[c];
            if (factor == 0.0) continue;
            SM_SIMD
            for (size_t k = c + 1; k < end; k++) row[k] -= factor * from[k];
            right[r] -= factor * right[c];
        }
    }
    return 1;
}

/* Panels, as long as there are many columns, and what follows from them; columns done, 0 if the
 * matrix is singular. */
size_t sm_eliminate_many(size_t n, double *matrix, double *right);

/* Of the upper half. */
SM_INLINE void sm_substitute_back(size_t n, const double *matrix, double *right) {
    for (size_t c = n; c-- > 0;) {
        const double *restrict row = matrix + c * n;
        double sum[SM_PANEL] = {right[c]}; /* stays in registers: one sum would wait for itself */
        size_t k = c + 1;
        for (; k + SM_PANEL <= n; k += SM_PANEL) {
            SM_SIMD
            for (size_t j = 0; j < SM_PANEL; j++) sum[j] -= row[k + j] * right[k + j];
        }
        for (; k < n; k++) sum[0] -= row[k] * right[k];
        right[c] = ((sum[0] + sum[1]) + (sum[2] + sum[3])) / row[c];
    }
}

/* right (n) = matrix^-1 right; the matrix (n, n) is used up. 0 if it is singular. */
SM_INLINE int sm_eliminate(size_t n, double *matrix, double *right) {
    size_t c = 0;
    if (n >= SM_MANY_EQUATIONS && !(c = sm_eliminate_many(n, matrix, right))) return 0;
    if (!sm_eliminate_panel(n, c, n, matrix, right)) return 0;
    sm_substitute_back(n, matrix, right);
    return 1;
}

/* Without row exchanges, in the upper half of a symmetric matrix: `count` (a literal, up to
 * SM_PANEL) rows from c on, and what follows from them. 0 if it is not positive definite. */
SM_INLINE int sm_eliminate_rows(const size_t count, size_t n, size_t c, double *matrix,
                                double *right) {
    const double *restrict top = matrix + c * n;
    double per[SM_PANEL] = {0.0}, factor[SM_PANEL];
    for (size_t r = c; r < n; r++) {
        const size_t own = r - c < count ? r - c : count; /* rows before it */
        double *restrict row = matrix + r * n;
        for (size_t b = 0; b < own; b++) {
            factor[b] = top[b * n + r] * per[b];
            right[r] -= factor[b] * right[c + b];
        }
        if (own == count) {
            SM_SIMD
            for (size_t k = r; k < n; k++)
                for (size_t b = 0; b < count; b++) row[k] -= factor[b] * top[b * n + k];
            continue;
        }
        for (size_t b = 0; b < own; b++) {
            SM_SIMD
            for (size_t k = r; k < n; k++) row[k] -= factor[b] * top[b * n + k];
        }
        if (!(row[r] > 0.0)) return 0;
        per[own] = 1.0 / row[r];
    }
    return 1;
}

/* As long as there are many rows; how many that is, or none. */
size_t sm_eliminate_many_rows(size_t n, double *matrix, double *right);

/* The same of a symmetric positive definite matrix, of which it has the upper half; 0 of another. */
SM_INLINE int sm_eliminate_symmetric(size_t n, double *matrix, double *right) {
    size_t c = 0;
    if (n >= SM_MANY_EQUATIONS && !(c = sm_eliminate_many_rows(n, matrix, right))) return 0;
    for (; c < n; c++)
        if (!sm_eliminate_rows(1, n, c, matrix, right)) return 0;
    sm_substitute_back(n, matrix, right);
    return 1;
}

#endif
