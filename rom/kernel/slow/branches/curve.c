/* Solution curves of F(y, p) = 0 by pseudo-arclength continuation (Keller 1977). */
#include <math.h>
#include <string.h>

#include "base/check.h"
#include "slipmode.h"

#define MOST SM_CURVE_UNKNOWNS
#define SHORTEST 1e-7      /* step, and distance of two points */
#define FIRST_STEP 0.25    /* of the largest */
#define LONGER 1.5         /* the next step may be, after ... */
#define EASY_PASSES 3      /* ... no more of Newton's */
#define LARGEST_TURN 0.15  /* of the tangent between two points [rad] */
#define CONVERGED 1e-8     /* Newton's last update: what it leaves is its square */

/* How far Newton's method may go. */
typedef struct {
    int passes;
    double longest;  /* update: longer ones are shortened to it */
    double farthest; /* from the start: beyond, there may not be an F */
} search;

static const search FOLLOWING = {8, INFINITY, 0.05}, SEARCHING = {30, 0.3, INFINITY};

/* In a row of doubles, as sm_curve_trace has it. */
typedef struct {
    double *z, *tangent, *jacobian;
} point;

static size_t row_size(int k) { return 2 * ((size_t)k + 1) + (size_t)k * (size_t)k; }

static point point_in(double *row, int k) {
    const point at = {row, row + k + 1, row + 2 * (k + 1)};
    return at;
}

static double dot(int n, const double *a, const double *b) {
    double sum = 0.0;
    for (int i = 0; i < n; i++) sum += a[i] * b[i];
    return sum;
}

static double distance(int n, const double *a, const double *b) {
    double square = 0.0;
    for (int i = 0; i < n; i++) square += (a[i] - b[i]) * (a[i] - b[i]);
    return sqrt(square);
}

/* A (n, n) with two right-hand sides beside it, which become the solutions; 0: A is singular. */
static int solved(int n, double A[MOST + 1][MOST + 3]) {
    for (int c = 0; c < n; c++) {
        int pivot = c;
        for (int r = c + 1; r < n; r++)
            if (fabs(A[r][c]) > fabs(A[pivot][c])) pivot = r;
        if (!(fabs(A[pivot][c]) > 0.0)) return 0;
        for (int k = c; k < n + 2; k++) {
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
                           const double *normal, const double *onward, point *found,
                           int *passes) {
    const int k = curve->unknowns, n = k + 1;
    double z[MOST + 1], F[MOST], J[MOST * (MOST + 1)];
    memcpy(z, guess, (size_t)n * sizeof *z);
    for (*passes = 0; *passes < limits.passes; ++*passes) {
        double A[MOST + 1][MOST + 3] = {{0.0}}, off = 0.0, size = 0.0, far = 0.0;
        if (curve->rates(curve->of, z, F, J) != SM_OK) return SM_NOT_CONVERGED;
        for (int r = 0; r < k; r++) {
            memcpy(A[r], J + r * n, (size_t)n * sizeof *J);
            A[r][n] = F[r];
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
        if (size <= CONVERGED) {
            double tangent[MOST + 1];
            for (int r = 0; r < n; r++) tangent[r] = A[r][n + 1];
            const double length = sqrt(dot(n, tangent, tangent));
            const double sign = dot(n, tangent, onward) < 0.0 ? -1.0 : 1.0;
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

static int is_valid(const sm_curve *curve) {
    return curve && curve->unknowns >= 1 && curve->unknowns <= MOST && curve->rates
           && curve->largest_step > 0.0;
}

sm_status sm_curve_point(const sm_curve *curve, const double *guess, const double *normal,
                         const double *onward, double *row) {
    if (!is_valid(curve) || !guess || !normal || !onward || !row) return SM_BAD_ARGUMENT;
    point found = point_in(row, curve->unknowns);
    int passes;
    return corrected(curve, FOLLOWING, guess, normal, onward, &found, &passes);
}

sm_status sm_curve_solve(const sm_curve *curve, size_t count, double *z) {
    if (!is_valid(curve) || !z) return SM_BAD_ARGUMENT;
    const int k = curve->unknowns, n = k + 1;
    double row[2 * (MOST + 1) + MOST * MOST], upwards[MOST + 1] = {0.0};
    upwards[k] = 1.0;
    point found = point_in(row, k);
    for (size_t i = 0; i < count; i++) {
        double *at = z + i * (size_t)n;
        int passes;
        const sm_status status =
            corrected(curve, SEARCHING, at, upwards, upwards, &found, &passes);
        for (int r = 0; r < n; r++) at[r] = status == SM_OK ? found.z[r] : NAN;
    }
    return SM_OK;
}

/* The point at p = 0 or p = 1 between two. */
static sm_status at_end(const sm_curve *curve, const point *inside, const point *outside,
                        point *found) {
    const int k = curve->unknowns, n = k + 1;
    const double end = outside->z[k] > 1.0 ? 1.0 : 0.0;
    const double part = (end - inside->z[k]) / (outside->z[k] - inside->z[k]);
    double guess[MOST + 1], upwards[MOST + 1] = {0.0};
    int passes;
    for (int r = 0; r < n; r++) guess[r] = inside->z[r] + part * (outside->z[r] - inside->z[r]);
    guess[k] = end;
    upwards[k] = 1.0;
    return corrected(curve, FOLLOWING, guess, upwards, inside->tangent, found, &passes);
}

/* The next point at a distance along the tangent, bent as between the last two, `before` being NULL
 * at the first; unless the curve bends too much for it. */
static sm_status stepped(const sm_curve *curve, const point *before, const point *last,
                         double step, point *found, int *passes) {
    const int n = curve->unknowns + 1;
    double guess[MOST + 1];
    for (int r = 0; r < n; r++) guess[r] = last->z[r] + step * last->tangent[r];
    if (before) {
        const double bend = 0.5 * step * step / distance(n, last->z, before->z);
        for (int r = 0; r < n; r++) guess[r] += bend * (last->tangent[r] - before->tangent[r]);
    }
    const sm_status status =
        corrected(curve, FOLLOWING, guess, last->tangent, last->tangent, found, passes);
    if (status != SM_OK) return status;
    return dot(n, found->tangent, last->tangent) < cos(LARGEST_TURN) ? SM_NOT_CONVERGED : SM_OK;
}

sm_status sm_curve_trace(const sm_curve *curve, size_t most, double *rows, size_t *count,
                         int32_t *closed) {
    if (!is_valid(curve) || !rows || !count || !closed || most < 1) return SM_BAD_ARGUMENT;
    const int k = curve->unknowns, n = k + 1;
    const size_t size = row_size(k);
    const point start = point_in(rows, k);
    double step = FIRST_STEP * curve->largest_step;
    int far = 0;
    *closed = 0;
    for (*count = 1; *count < most;) {
        const point last = point_in(rows + (*count - 1) * size, k);
        const point before = point_in(*count > 1 ? rows + (*count - 2) * size : rows, k);
        point next = point_in(rows + *count * size, k);
        int passes;
        if (stepped(curve, *count > 1 ? &before : NULL, &last, step, &next, &passes) != SM_OK) {
            step *= 0.5;
            if (step < SHORTEST) break;
            continue;
        }
        if (next.z[k] < 0.0 || next.z[k] > 1.0) {
            double row[2 * (MOST + 1) + MOST * MOST];
            point end = point_in(row, k);
            if (at_end(curve, &last, &next, &end) == SM_OK
                && distance(n, end.z, last.z) > SHORTEST)
                memcpy(rows + (*count)++ * size, row, size * sizeof *row);
            break;
        }
        if (passes <= EASY_PASSES) step = fmin(LONGER * step, curve->largest_step);
        const double away = distance(n, next.z, start.z);
        ++*count;
        if (far && away < step && dot(n, next.tangent, start.tangent) > 0.0) {
            *closed = 1;
            break;
        }
        far |= away > 2.0 * step;
    }
    return SM_OK;
}
