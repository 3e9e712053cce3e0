/* Eigenvalues by Francis' implicit double QR steps (Golub and Van Loan, Matrix computations, 7.5). */
#include "slow/branches/curve.h"

#include <float.h>
#include <math.h>

#include "base/lanes.h"

#define MOST SM_EIGENVALUES
#define ROUNDING (16.0 * DBL_EPSILON)
#define STEPS 160      /* for one eigenvalue, or pair: where they are double it takes 30 */

/* H becomes Q H Q, Q the reflection of rows first, first + 1, ... that turns x (m) into the first of
 * them; columns left to n and rows above `bottom` are those that count. `m` is a literal. */
SM_INLINE void reflect(int n, double H[MOST][MOST], int first, int m, const double *x, int left,
                       int bottom) {
    double v[3] = {0.0}, square = 0.0;
    for (int i = 0; i < m; i++) square += x[i] * x[i];
    if (square == 0.0) return;
    const double length = sqrt(square), factor = 1.0 / (square + length * fabs(x[0]));
    for (int i = 0; i < m; i++) v[i] = x[i];
    v[0] += copysign(length, x[0]);
    for (int c = left; c < n; c++) {
        double along = 0.0;
        for (int i = 0; i < m; i++) along += v[i] * H[first + i][c];
        for (int i = 0; i < m; i++) H[first + i][c] -= factor * along * v[i];
    }
    for (int r = 0; r < bottom; r++) {
        double along = 0.0;
        for (int i = 0; i < m; i++) along += v[i] * H[r][first + i];
        for (int i = 0; i < m; i++) H[r][first + i] -= factor * along * v[i];
    }
}

/* One step on rows and columns low to high, two more at least: both shifts at once. */
static void step(double H[MOST][MOST], int low, int high, int exceptional) {
    double sum = H[high - 1][high - 1] + H[high][high], x[3];
    double product = H[high - 1][high - 1] * H[high][high] - H[high - 1][high] * H[high][high - 1];
    if (exceptional) {
        const double shift = fabs(H[high][high - 1]) + fabs(H[high - 1][high - 2]);
        sum = 1.5 * shift;
        product = shift * shift;
    }
    x[0] = H[low][low] * (H[low][low] - sum) + H[low][low + 1] * H[low + 1][low] + product;
    x[1] = H[low + 1][low] * (H[low][low] + H[low + 1][low + 1] - sum);
    x[2] = H[low + 1][low] * H[low + 2][low + 1];
    for (int k = low; k < high; k++) {
        const int m = k + 2 <= high ? 3 : 2;
        if (k > low)
            for (int i = 0; i < m; i++) x[i] = H[k + i][k - 1];
        const int left = k > low ? k - 1 : low, bottom = k + 3 <= high ? k + 4 : high + 1;
        if (m == 3)
            reflect(high + 1, H, k, 3, x, left, bottom);
        else
            reflect(high + 1, H, k, 2, x, left, bottom);
        for (int i = 1; k > low && i < m; i++) H[k + i][k - 1] = 0.0;
    }
}

/* Of [[a, b], [c, d]]. */
static void of_two(double a, double b, double c, double d, double *values) {
    const double mean = 0.5 * (a + d), square = 0.25 * (a - d) * (a - d) + b * c;
    const double root = sqrt(fabs(square)), turns = square < 0.0;
    const double apart = turns ? 0.0 : root;
    values[0] = mean + apart;
    values[1] = turns ? root : 0.0;
    values[2] = mean - apart;
    values[3] = turns ? -root : 0.0;
}

static void sort(int n, double *values) {
    for (int i = 1; i < n; i++)
        for (int k = i; k > 0 && values[2 * k] > values[2 * k - 2]; k--)
            for (int part = 0; part < 2; part++) {
                const double swapped = values[2 * k + part];
                values[2 * k + part] = values[2 * k - 2 + part];
                values[2 * k - 2 + part] = swapped;
            }
}

void sm_eigenvalues(int n, const double *matrix, double *values) {
    double H[MOST][MOST] = {{0.0}};
    for (int r = 0; r < n; r++)
        for (int c = 0; c < n; c++) H[r][c] = matrix[r * n + c];
    for (int c = 0; c + 2 < n; c++) {
        double x[MOST] = {0.0};
        for (int r = c + 1; r < n; r++) x[r - c - 1] = H[r][c];
        if (n - c == 4)
            reflect(n, H, c + 1, 3, x, c, n);
        else
            reflect(n, H, c + 1, 2, x, c, n);
        for (int r = c + 2; r < n; r++) H[r][c] = 0.0;
    }
    for (int i = 0; i < 2 * n; i++) values[i] = NAN;
    int steps = 0;
    for (int high = n - 1; high >= 0;) {
        int low = high;
        for (; low > 0; low--) {
            double beside = fabs(H[low - 1][low - 1]) + fabs(H[low][low]);
            if (low > 1) beside += fabs(H[low - 1][low - 2]);
            if (low < high) beside += fabs(H[low + 1][low]);
            if (fabs(H[low][low - 1]) <= ROUNDING * beside) break;
        }
        if (low + 1 < high) {
            if (++steps > STEPS) break;
            step(H, low, high, steps % 40 == 0); /* now and then another shift: cycles end */
            continue;
        }
        if (low == high) {
            values[2 * low] = H[low][low];
            values[2 * low + 1] = 0.0;
        } else {
            of_two(H[low][low], H[low][high], H[high][low], H[high][high], values + 2 * low);
        }
        high = low - 1;
        steps = 0;
    }
    sort(n, values);
}
