#include "slow/branches/curve.h"

#include <string.h>

#define MOST SM_CURVE_UNKNOWNS

/* How far Newton's method may go. */
typedef struct {
    int passes;
    double good;     /* last update: what it leaves is its square */
    double longest;  /* update: longer ones are shortened to it */
    double farthest; /* from the start: beyond, there may not be an F */
} search;

static const search FOLLOWING = {8, 5e-7, INFINITY, 0.05}, BISECTING = {8, 1e-8, INFINITY, 0.05},
                    SEARCHING = {30, 1e-8, 0.3, INFINITY};

/* Replaces the two right-hand sides in the last columns by the solutions; returns 0 if the matrix
 * (n, n) is singular. */
static int solved(int n, double A[MOST + 1][MOST + 3]) {
    for (int c = 0; c < n; c++) {
        int pivot = c;
        for (int r = c + 1; r < n; r++)
            if (fabs(A[r][c]) > fabs(A[pivot][c])) pivot = r;
        if (!(fabs(A[pivot][c]) > 0.0)) return 0;
        for (int k = c; pivot != c && k < n + 2; k++) {
            const double swapped = A[c][k];
            A[c][k] = A[pivot][k];
            A[pivot][k] = swapped;
        }
        for (int r = c + 1; r < n; r++) {
            const double factor = A[r][c] / A[c][c];
            for (int k = c + 1; k < n + 2; k++) A[r][k] -= factor * A[c][k];
        }
    }
    for (int right = n; right < n + 2; right++)
        for (int r = n - 1; r >= 0; r--) {
            double value = A[r][right];
            for (int k = r + 1; k < n; k++) value -= A[r][k] * A[k][right];
            A[r][right] = value / A[r][r];
        }
    return 1;
}

/* Newton's method on F = 0 in the plane through a guess; the tangent points onward. */
static sm_status corrected(const sm_curve *curve, search limits, const double *guess,
                           const double *normal, const double *onward, sm_curve_point *found) {
    const int k = curve->unknowns, n = k + 1;
    double z[MOST + 1], F[MOST], J[MOST * (MOST + 1)];
    memcpy(z, guess, (size_t)n * sizeof *z);
    for (int passes = 0; passes < limits.passes; passes++) {
        double A[MOST + 1][MOST + 3], off = 0.0, size = 0.0, far = 0.0;
        if (curve->rates(curve->of, z, F, J) != SM_OK) return SM_NOT_CONVERGED;
        for (int r = 0; r < k; r++) {
            memcpy(A[r], J + r * n, (size_t)n * sizeof *J);
            A[r][n] = F[r];
            A[r][n + 1] = 0.0;
        }
        for (int c = 0; c < n; c++) off += normal[c] * (z[c] - guess[c]);
        memcpy(A[k], normal, (size_t)n * sizeof *normal);
        A[k][n] = off;
        A[k][n + 1] = 1.0; /* the tangent: J t = 0, normal t = 1 */
        if (!solved(n, A)) return SM_NOT_CONVERGED;
        for (int r = 0; r < n; r++) {
            if (!isfinite(A[r][n])) return SM_NOT_CONVERGED;
            size = fmax(size, fabs(A[r][n]));
        }
        if (size <= limits.good) {
            double tangent[MOST + 1];
            found->passes = passes;
            for (int r = 0; r < n; r++) tangent[r] = A[r][n + 1];
            const double length = sqrt(sm_curve_dot(n, tangent, tangent));
            const double sign = sm_curve_dot(n, tangent, onward) < 0.0 ? -1.0 : 1.0;
            for (int r = 0; r < n; r++) found->tangent[r] = sign * tangent[r] / length;
            for (int r = 0; r < n; r++) found->z[r] = z[r] - A[r][n];
            for (int r = 0; r < k; r++)
                memcpy(found->jacobian + r * k, J + r * n, (size_t)k * sizeof *J);
            return SM_OK;
        }
        const double part = size > limits.longest ? limits.longest / size : 1.0;
        for (int r = 0; r < n; r++) {
            z[r] -= part * A[r][n];
            far = fmax(far, fabs(z[r] - guess[r]));
        }
        if (far > limits.farthest) return SM_NOT_CONVERGED;
    }
    return SM_NOT_CONVERGED;
}

int sm_curve_is_valid(const sm_curve *curve) {
    return curve && curve->unknowns >= 1 && curve->unknowns <= MOST && curve->rates
           && curve->largest_step > 0.0;
}

sm_status sm_curve_corrected(const sm_curve *curve, const double *guess, const double *normal,
                             const double *onward, sm_curve_point *found) {
    return corrected(curve, FOLLOWING, guess, normal, onward, found);
}

sm_status sm_curve_between(const sm_curve *curve, const double *guess, const double *normal,
                           const double *onward, sm_curve_point *found) {
    return corrected(curve, BISECTING, guess, normal, onward, found);
}

sm_status sm_curve_solved(const sm_curve *curve, double *z) {
    if (!sm_curve_is_valid(curve) || !z) return SM_BAD_ARGUMENT;
    const int k = curve->unknowns;
    double upwards[MOST + 1] = {0.0};
    sm_curve_point found;
    upwards[k] = 1.0;
    const sm_status status = corrected(curve, SEARCHING, z, upwards, upwards, &found);
    if (status == SM_OK) memcpy(z, found.z, ((size_t)k + 1) * sizeof *z);
    return status;
}
