/* Compiled without contraction to fused operations: vectors of every width give the same bits. */
#include "base/dense.h"

#include "base/lanes.h"

double sm_dot(size_t n, const double *a, const double *b) {
    double sum = 0.0;
    for (size_t i = 0; i < n; i++) sum += a[i] * b[i];
    return sum;
}

/* Exchanges rows a and b of A, from column `first` on, and of the right-hand side. */
static void exchange_rows(size_t n, size_t a, size_t b, size_t first, double *A, double *right) {
    for (size_t k = first; k < n; k++) {
        const double kept = A[a * n + k];
        A[a * n + k] = A[b * n + k];
        A[b * n + k] = kept;
    }
    const double kept = right[a];
    right[a] = right[b];
    right[b] = kept;
}

SM_HOT int sm_eliminate(size_t n, double *A, double *right) {
    for (size_t c = 0; c < n; c++) {
        const double *restrict top = A + c * n;
        size_t pivot = c;
        for (size_t r = c + 1; r < n; r++)
            if (fabs(A[r * n + c]) > fabs(A[pivot * n + c])) pivot = r;
        if (!(fabs(A[pivot * n + c]) > 0.0)) return 0;
        if (pivot != c) exchange_rows(n, c, pivot, c, A, right);
        for (size_t r = c + 1; r < n; r++) {
            double *restrict row = A + r * n;
            const double factor = row[c] / top[c];
            if (factor == 0.0) continue;
            SM_SIMD
            for (size_t k = c + 1; k < n; k++) row[k] -= factor * top[k];
            right[r] -= factor * right[c];
        }
    }
    for (size_t c = n; c-- > 0;) {
        for (size_t k = c + 1; k < n; k++) right[c] -= A[c * n + k] * right[k];
        right[c] /= A[c * n + c];
    }
    return 1;
}

size_t sm_cholesky(size_t n, double least, double *A) {
    size_t independent = 0;
    for (size_t i = 0; i < n; i++) {
        double *row = A + i * n;
        const double smallest = least * row[i];
        for (size_t j = 0; j <= i; j++) {
            const double *other = A + j * n, rest = row[j] - sm_dot(j, row, other);
            if (j < i)
                row[j] = other[j] > 0.0 ? rest / other[j] : 0.0;
            else
                row[i] = rest > smallest && isfinite(rest) ? sqrt(rest) : 0.0;
        }
        independent += row[i] > 0.0;
    }
    return independent;
}

void sm_cholesky_solve(size_t n, const double *L, double *right) {
    for (size_t i = 0; i < n; i++) {
        const double *row = L + i * n, rest = right[i] - sm_dot(i, row, right);
        right[i] = row[i] > 0.0 ? rest / row[i] : 0.0;
    }
    for (size_t i = n; i-- > 0;) {
        right[i] = L[i * n + i] > 0.0 ? right[i] / L[i * n + i] : 0.0;
        for (size_t k = 0; k < i; k++) right[k] -= L[i * n + k] * right[i];
    }
}
