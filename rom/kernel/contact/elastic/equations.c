/* Compiled without contraction: what the widest vectors find has the bits of the narrowest. */
#include "contact/elastic/equations.h"

#define TOGETHER 4 /* vectors of sums: one waits for itself */

/* to -= R[:, column] by in some vectors of rows, a literal; each sum takes its products in order. */
SM_INLINE void subtract(const size_t vectors, size_t n, const double *R, const int32_t *column,
                        size_t columns, const double *by, double *to) {
    double sum[TOGETHER][SM_VECTOR]; /* stays in registers */
    for (size_t j = 0; j < vectors; j++) memcpy(sum[j], to + j * SM_VECTOR, sizeof sum[j]);
    for (size_t b = 0; b < columns; b++) {
        const double *restrict from = R + (size_t)column[b] * n;
        const double times = by[b];
        for (size_t j = 0; j < vectors; j++) {
            SM_SIMD
            for (size_t k = 0; k < SM_VECTOR; k++) sum[j][k] -= from[j * SM_VECTOR + k] * times;
        }
    }
    for (size_t j = 0; j < vectors; j++) memcpy(to + j * SM_VECTOR, sum[j], sizeof sum[j]);
}

SM_HOT size_t sm_subtract_many(size_t n, const double *R, const int32_t *column, size_t columns,
                               const double *by, double *to) {
    size_t i = 0;
    for (; n - i >= TOGETHER * SM_VECTOR; i += TOGETHER * SM_VECTOR)
        subtract(TOGETHER, n, R + i, column, columns, by, to + i);
    const size_t left = (n - i) / SM_VECTOR;
    if (left == 3) subtract(3, n, R + i, column, columns, by, to + i);
    if (left == 2) subtract(2, n, R + i, column, columns, by, to + i);
    if (left == 1) subtract(1, n, R + i, column, columns, by, to + i);
    return i + left * SM_VECTOR;
}

/* The same in the columns after a panel: each entry takes its differences in their order. */
SM_INLINE void follow(size_t n, size_t c, double *matrix) {
    const size_t end = c + SM_PANEL;
    double *const top = matrix + c * n;
    for (size_t r = 1; r < SM_PANEL; r++)
        for (size_t b = 0; b < r; b++) {
            const double factor = top[r * n + c + b];
            SM_SIMD
            for (size_t k = end; k < n; k++) top[r * n + k] -= factor * top[b * n + k];
        }
    const double *restrict a_0 = top, *restrict a_1 = top + n, *restrict a_2 = top + 2 * n,
                 *restrict a_3 = top + 3 * n;
    for (size_t r = end; r < n; r++) {
        double *restrict row = matrix + r * n;
        const double f_0 = row[c], f_1 = row[c + 1], f_2 = row[c + 2], f_3 = row[c + 3];
        SM_SIMD
        for (size_t k = end; k < n; k++)
            row[k] = row[k] - f_0 * a_0[k] - f_1 * a_1[k] - f_2 * a_2[k] - f_3 * a_3[k];
    }
}

SM_HOT size_t sm_eliminate_many(size_t n, double *matrix, double *right) {
    size_t c = 0;
    for (; n - c >= SM_MANY_EQUATIONS; c += SM_PANEL) {
        if (!sm_eliminate_panel(n, c, c + SM_PANEL, matrix, right)) return 0;
        follow(n, c, matrix);
    }
    return c;
}

SM_HOT size_t sm_eliminate_many_rows(size_t n, double *matrix, double *right) {
    size_t c = 0;
    for (; n - c >= SM_MANY_EQUATIONS; c += SM_PANEL)
        if (!sm_eliminate_rows(SM_PANEL, n, c, matrix, right)) return 0;
    return c;
}
