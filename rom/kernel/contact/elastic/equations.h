/* Gauss's elimination with row exchanges; what many contacts do otherwise, to the same bits. */
#ifndef SLIPMODE_EQUATIONS_H
#define SLIPMODE_EQUATIONS_H

#include "base/lanes.h"

#define SM_MANY_EQUATIONS 24
#define SM_PANEL 4 /* columns that are eliminated together */

/* to (n) -= R[:, column] by in rows of R (n, n), symmetric, side by side, for a sum waits for itself
 * alone; how many rows that is. NULL: all columns. */
size_t sm_subtract_many(size_t n, const double *R, const int32_t *column, size_t columns,
                        const double *by, double *to);

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

/* right (n) = matrix^-1 right; the matrix (n, n) is used up. 0 if it is singular. */
SM_INLINE int sm_eliminate(size_t n, double *matrix, double *right) {
    size_t c = 0;
    if (n >= SM_MANY_EQUATIONS && !(c = sm_eliminate_many(n, matrix, right))) return 0;
    if (!sm_eliminate_panel(n, c, n, matrix, right)) return 0;
    for (c = n; c-- > 0;) {
        for (size_t k = c + 1; k < n; k++) right[c] -= matrix[c * n + k] * right[k];
        right[c] /= matrix[c * n + c];
    }
    return 1;
}

#endif
