/* Solution curves of F(y, p) = 0 by pseudo-arclength continuation (Keller 1977). */
#include <math.h>
#include <string.h>

#include "slipmode.h"

#define MOST SM_CURVE_UNKNOWNS
#define SHORTEST 1e-7 /* step, and distance of two points */
#define ROW(unknowns) (2 * ((unknowns) + 1) + (unknowns) * (unknowns)) /* doubles */

/* z = (y, p), the direction there, and dF/dy (k, k). */
typedef struct {
    double z[SM_CURVE_UNKNOWNS + 1], tangent[SM_CURVE_UNKNOWNS + 1];
    double jacobian[SM_CURVE_UNKNOWNS * SM_CURVE_UNKNOWNS];
    int passes; /* of Newton's method that led to it */
} point;

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
                           const double *normal, const double *onward, point *found) {
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
        if (size <= fmax(limits.good, curve->noise)) {
            double tangent[MOST + 1];
            found->passes = passes;
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
           && curve->largest_step > 0.0 && curve->noise >= 0.0;
}

/* Where points of a branch go: the rows that follow one another by `stride` doubles. */
typedef struct {
    double *row;
    ptrdiff_t stride;
    double sense; /* of the tangent in a row: 1, or -1 where the curve is followed backwards */
} rows;

static void put(const sm_curve *curve, rows out, size_t number, const point *at) {
    const int k = curve->unknowns, n = k + 1;
    double *row = out.row + (ptrdiff_t)number * out.stride;
    memcpy(row, at->z, (size_t)n * sizeof *row);
    for (int i = 0; i < n; i++) row[n + i] = out.sense * at->tangent[i];
    memcpy(row + 2 * n, at->jacobian, (size_t)(k * k) * sizeof *row);
}

/* The point at p = 0 or p = 1 between two. */
static sm_status at_end(const sm_curve *curve, const point *inside,
                        const point *outside, point *found) {
    const int k = curve->unknowns, n = k + 1;
    const double end = outside->z[k] > 1.0 ? 1.0 : 0.0;
    const double part = (end - inside->z[k]) / (outside->z[k] - inside->z[k]);
    double guess[MOST + 1], upwards[MOST + 1] = {0.0};
    for (int r = 0; r < n; r++) guess[r] = inside->z[r] + part * (outside->z[r] - inside->z[r]);
    guess[k] = end;
    upwards[k] = 1.0;
    return corrected(curve, FOLLOWING, guess, upwards, inside->tangent, found);
}

/* The next point at a distance along the tangent, guessed on the cubic through the last two and their
 * tangents, `before` being NULL at the first; unless the curve bends too much for it. */
static sm_status stepped(const sm_curve *curve, const point *before,
                         const point *last, double step, point *found) {
    const int n = curve->unknowns + 1;
    double guess[MOST + 1];
    for (int r = 0; r < n; r++) guess[r] = last->z[r] + step * last->tangent[r];
    if (before) {
        const double length = distance(n, last->z, before->z), on = step / length;
        for (int r = 0; r < n; r++) {
            const double chord = (last->z[r] - before->z[r]) / length;
            const double turned = last->tangent[r] - chord;
            const double twisted = turned + before->tangent[r] - chord;
            guess[r] += step * on * (turned + (1.0 + on) * twisted);
        }
    }
    const sm_status status =
        corrected(curve, FOLLOWING, guess, last->tangent, last->tangent, found);
    if (status != SM_OK) return status;
    const double turn = dot(n, found->tangent, last->tangent);
    return turn < cos(0.15) ? SM_NOT_CONVERGED : SM_OK;
}

/* From a start on along its tangent; how many points there are, at most `most`. */
static size_t traced(const sm_curve *curve, const point *start, size_t most, rows out,
                     int *closed) {
    const int k = curve->unknowns, n = k + 1;
    point before, last = *start, next;
    double step = 0.25 * curve->largest_step;
    size_t count = 1;
    int far = 0;
    put(curve, out, 0, start);
    while (count < most) {
        if (stepped(curve, count > 1 ? &before : NULL, &last, step, &next) != SM_OK) {
            step *= 0.5;
            if (step < SHORTEST) break;
            continue;
        }
        if (next.z[k] < 0.0 || next.z[k] > 1.0) {
            point end;
            if (at_end(curve, &last, &next, &end) == SM_OK
                && distance(n, end.z, last.z) > SHORTEST)
                put(curve, out, count++, &end);
            break;
        }
        /* steps grow where Newton's method has little to do */
        if (next.passes <= 3) step = fmin(1.5 * step, curve->largest_step);
        put(curve, out, count++, &next);
        const double away = distance(n, next.z, start->z);
        if (far && away < step && dot(n, next.tangent, start->tangent) > 0.0) {
            *closed = 1;
            break;
        }
        far |= away > 2.0 * step;
        before = last;
        last = next;
    }
    return count;
}

sm_status sm_curve_branch(const sm_curve *curve, const double *start, size_t most, double *points,
                          sm_branch *branch) {
    if (!is_valid(curve) || !start || !points || !branch || most < 1)
        return SM_BAD_ARGUMENT;
    const int k = curve->unknowns, n = k + 1;
    const ptrdiff_t row = ROW(k);
    double upwards[MOST + 1] = {0.0};
    point at;
    upwards[k] = 1.0;
    const sm_status status = corrected(curve, FOLLOWING, start, upwards, upwards, &at);
    if (status != SM_OK) return status;
    double *middle = points + (ptrdiff_t)(most - 1) * row;
    const rows onwards = {middle, row, 1.0}, back = {middle, -row, -1.0};
    int comes_back = 0;
    branch->after = traced(curve, &at, most, onwards, &comes_back) - 1;
    branch->before = 0;
    branch->closed = comes_back;
    if (branch->closed) return SM_OK;
    for (int i = 0; i < n; i++) at.tangent[i] = -at.tangent[i];
    branch->before = traced(curve, &at, most, back, &comes_back) - 1;
    return SM_OK;
}

sm_status sm_curve_point_near(const sm_curve *curve, const double *guess, const double *normal,
                              const double *onward, double *row) {
    if (!is_valid(curve) || !guess || !normal || !onward || !row) return SM_BAD_ARGUMENT;
    point found;
    const sm_status status = corrected(curve, BISECTING, guess, normal, onward, &found);
    if (status == SM_OK) put(curve, (rows){row, 0, 1.0}, 0, &found);
    return status;
}

sm_status sm_curve_solved(const sm_curve *curve, double *z) {
    if (!is_valid(curve) || !z) return SM_BAD_ARGUMENT;
    const int k = curve->unknowns;
    double upwards[MOST + 1] = {0.0};
    point found;
    upwards[k] = 1.0;
    const sm_status status = corrected(curve, SEARCHING, z, upwards, upwards, &found);
    if (status == SM_OK) memcpy(z, found.z, ((size_t)k + 1) * sizeof *z);
    return status;
}
