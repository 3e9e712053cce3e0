/* Points on a branch of steady states, eqs. (22) to (25): whether a solution lies on it, and the
 * stability of its points. A point is stable if all roots of the characteristic polynomial of dF/dy
 * have negative real parts, by Routh's criterion. Python and the explorer call it, to trace each
 * branch once and to draw its stability. */
#include <math.h>
#include <string.h>

#include "slipmode.h"

/* Distance of a solution from the chord between two points up to which it lies on the branch: the
 * curve deviates from its chord by up to 0.05 of the chord, and errors of points are below 1e-6. */
#define CHORD_DEVIATION 0.05
#define POINT_ERROR 1e-6

int32_t sm_curve_passes(int32_t unknowns, size_t points, size_t stride, const double *row,
                        const double *z) {
    const int n = unknowns + 1;
    for (size_t k = 0; k + 1 < points; k++, row += stride) {
        double square = 0.0, along = 0.0, away = 0.0;
        for (int r = 0; r < n; r++) {
            const double chord = row[stride + (size_t)r] - row[r];
            square += chord * chord;
            along += (z[r] - row[r]) * chord;
        }
        if (!(square > 0.0)) continue;
        const double part = fmin(fmax(along / square, 0.0), 1.0);
        for (int r = 0; r < n; r++) {
            const double off = z[r] - row[r] - part * (row[stride + (size_t)r] - row[r]);
            away += off * off;
        }
        if (sqrt(away) <= POINT_ERROR + CHORD_DEVIATION * sqrt(square)) return 1;
    }
    return 0;
}

/* Computes the characteristic polynomial of a matrix (k, k), the highest power first (Faddeev,
 * LeVerrier). */
static void characteristic(int k, const double *J, double *coefficient) {
    double M[SM_CURVE_UNKNOWNS * SM_CURVE_UNKNOWNS] = {0.0};
    coefficient[0] = 1.0;
    for (int power = 1; power <= k; power++) {
        double next[SM_CURVE_UNKNOWNS * SM_CURVE_UNKNOWNS] = {0.0}, trace = 0.0;
        for (int i = 0; i < k; i++) M[i * k + i] += coefficient[power - 1];
        for (int r = 0; r < k; r++)
            for (int c = 0; c < k; c++)
                for (int i = 0; i < k; i++) next[r * k + c] += J[r * k + i] * M[i * k + c];
        memcpy(M, next, sizeof M);
        for (int i = 0; i < k; i++) trace += M[i * k + i];
        coefficient[power] = -trace / power;
    }
}

/* Routh's reduction: all roots of c_0 x^n + c_1 x^(n-1) + ... have negative real parts if c_0 and
 * c_1 have one sign, and if this holds for a polynomial of a degree less. */
int32_t sm_curve_is_stable(int32_t unknowns, const double *row) {
    double c[SM_CURVE_UNKNOWNS + 2] = {0.0};
    characteristic(unknowns, row + 2 * (unknowns + 1), c);
    for (int degree = unknowns; degree > 0; degree--) {
        if (!(c[1] > 0.0)) return 0;
        const double ratio = c[0] / c[1];
        for (int i = 1; i <= degree; i++) c[i - 1] = i % 2 ? c[i] : c[i] - ratio * c[i + 1];
        c[degree] = 0.0;
    }
    return 1;
}
