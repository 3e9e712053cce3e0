/* Solution curves of F(y, p) = 0 by pseudo-arclength continuation (Keller 1977); Python and the
 * explorer trace the steady states of forced.c, eqs. (22) to (25), with it. A point z = (y, p) is
 * predicted on the tangent, or on the cubic through the last two points, and corrected by Newton's
 * method on F = 0 and normal (z - guess) = 0. Its tangent solves J t = 0. Steps become longer if
 * Newton's method needs few iterations. */
#include <math.h>
#include <string.h>

#include "base/check.h"
#include "base/dense.h"
#include "base/hermite.h"
#include "slipmode.h"

#define MOST SM_CURVE_UNKNOWNS
/* Shortest step, and smallest distance of two different points, in units of z. */
#define SHORTEST_STEP 1e-7
/* Shortest step / error of z (curve->noise) on which the direction of the tangent is significant;
 * the shortest step is a quarter. */
#define SIGNIFICANT_STEP 50.0
#define FIRST_STEP 0.25 /* relative to the largest step */
/* Largest angle between successive tangents [rad]: 0.15 = 8.6 degrees. */
#define LARGEST_TURN 0.15
/* Steps grow by this factor if Newton's method needs at most EASY_ITERATIONS. */
#define GROWTH 1.5
#define EASY_ITERATIONS 3
#define ROW(unknowns) (2 * ((unknowns) + 1) + (unknowns) * (unknowns)) /* doubles of a point */

/* z = (y, p), the unit tangent, and dF/dy (k, k). */
typedef struct {
    double z[SM_CURVE_UNKNOWNS + 1], tangent[SM_CURVE_UNKNOWNS + 1];
    double jacobian[SM_CURVE_UNKNOWNS * SM_CURVE_UNKNOWNS];
    int iterations; /* of Newton's method */
} point;

/* Returns the distance between two points. */
static double distance(int n, const double *a, const double *b) {
    double square = 0.0;
    for (int i = 0; i < n; i++) square += (a[i] - b[i]) * (a[i] - b[i]);
    return sqrt(square);
}

/* Limits of Newton's method. */
typedef struct {
    int iterations;
    double tolerance; /* of the last update: the remaining error is about its square */
    double longest;   /* update: longer ones are shortened */
    double farthest;  /* distance from the guess */
} search;

/* In units of z: corrections along a curve, which start near the solution; corrections of points
 * that are located more precisely; searches from an amplitude far from the solution. */
static const search FOLLOWING = {8, 5e-7, INFINITY, 0.05}, BISECTING = {8, 1e-8, INFINITY, 0.05},
                    SEARCHING = {30, 1e-8, 0.3, INFINITY};

/* Solves with the matrix of the rows J (n - 1, n) and the normal (n); replaces the right-hand side
 * by the solution. Returns 0 if the matrix is singular. */
static int solve_bordered(int n, const double *J, const double *normal, double *right) {
    double matrix[(MOST + 1) * (MOST + 1)];
    const size_t row = (size_t)n, above = (row - 1) * row;
    memcpy(matrix, J, above * sizeof *J);
    memcpy(matrix + above, normal, row * sizeof *normal);
    return sm_eliminate(row, matrix, right);
}

/* Solves F = 0 in the plane through a guess by Newton's method; the tangent points onward. */
static sm_status correct(const sm_curve *curve, search limits, const double *guess,
                           const double *normal, const double *onward, point *found) {
    const int k = curve->unknowns, n = k + 1;
    double z[MOST + 1], J[MOST * (MOST + 1)];
    memcpy(z, guess, (size_t)n * sizeof *z);
    for (int iterations = 0; iterations < limits.iterations; iterations++) {
        double update[MOST + 1], size = 0.0, far = 0.0; /* J u = F, normal u = normal (z - guess) */
        if (curve->rates(curve->of, z, update, J) != SM_OK) return SM_NOT_CONVERGED;
        update[k] = 0.0;
        for (int c = 0; c < n; c++) update[k] += normal[c] * (z[c] - guess[c]);
        if (!solve_bordered(n, J, normal, update)) return SM_NOT_CONVERGED;
        for (int r = 0; r < n; r++) {
            if (!isfinite(update[r])) return SM_NOT_CONVERGED;
            size = fmax(size, fabs(update[r]));
        }
        if (size <= fmax(limits.tolerance, curve->noise)) {
            double tangent[MOST + 1] = {0.0}; /* J t = 0, normal t = 1 */
            tangent[k] = 1.0;
            if (!solve_bordered(n, J, normal, tangent)) return SM_NOT_CONVERGED;
            const double length = sqrt(sm_dot((size_t)n, tangent, tangent));
            const double sign = sm_dot((size_t)n, tangent, onward) < 0.0 ? -1.0 : 1.0;
            found->iterations = iterations;
            for (int r = 0; r < n; r++) {
                found->tangent[r] = sign * tangent[r] / length;
                found->z[r] = z[r] - update[r];
            }
            for (int r = 0; r < k; r++)
                memcpy(found->jacobian + r * k, J + r * n, (size_t)k * sizeof *J);
            return SM_OK;
        }
        const double part = size > limits.longest ? limits.longest / size : 1.0;
        for (int r = 0; r < n; r++) {
            z[r] -= part * update[r];
            far = fmax(far, fabs(z[r] - guess[r]));
        }
        if (far > limits.farthest) return SM_NOT_CONVERGED;
    }
    return SM_NOT_CONVERGED;
}

/* Returns whether sizes and numbers of the curve are valid. */
static int is_valid(const sm_curve *curve) {
    return curve && curve->unknowns >= 1 && curve->unknowns <= MOST && curve->rates
           && curve->largest_step > 0.0 && curve->noise >= 0.0
           && isfinite(curve->largest_step) && isfinite(curve->noise);
}

/* Rows of points of a branch, `stride` doubles apart. */
typedef struct {
    double *row;
    ptrdiff_t stride;
    double sense; /* of the tangent in a row: 1, or -1 where the curve is followed backwards */
} rows;

/* Writes a point into a row. */
static void put(const sm_curve *curve, rows out, size_t number, const point *at) {
    const int k = curve->unknowns, n = k + 1;
    double *row = out.row + (ptrdiff_t)number * out.stride;
    memcpy(row, at->z, (size_t)n * sizeof *row);
    for (int i = 0; i < n; i++) row[n + i] = out.sense * at->tangent[i];
    memcpy(row + 2 * n, at->jacobian, (size_t)(k * k) * sizeof *row);
}

/* Computes the point at p = 0 or p = 1 between two points. */
static sm_status end_point(const sm_curve *curve, const point *inside,
                        const point *outside, point *found) {
    const int k = curve->unknowns, n = k + 1;
    const double end = outside->z[k] > 1.0 ? 1.0 : 0.0;
    const double part = (end - inside->z[k]) / (outside->z[k] - inside->z[k]);
    double guess[MOST + 1], upwards[MOST + 1] = {0.0};
    for (int r = 0; r < n; r++) guess[r] = inside->z[r] + part * (outside->z[r] - inside->z[r]);
    guess[k] = end;
    upwards[k] = 1.0;
    return correct(curve, FOLLOWING, guess, upwards, inside->tangent, found);
}

/* Computes the next point at a distance along the tangent. The guess lies on the cubic through the
 * last two points and their tangents; `before` is NULL at the first point. Fails if the curve turns
 * too far, unless the step is so short that errors of the rates turn it. */
static sm_status predict_and_correct(const sm_curve *curve, const point *before,
                         const point *last, double step, point *found) {
    const int n = curve->unknowns + 1;
    double guess[MOST + 1];
    for (int r = 0; r < n; r++) guess[r] = last->z[r] + step * last->tangent[r];
    if (before) {
        const double length = distance(n, last->z, before->z);
        const sm_hermite at = sm_hermite_at(length, 1.0 + step / length);
        for (int r = 0; r < n; r++)
            guess[r] = sm_hermite_value(&at.value, before->z[r], before->tangent[r], last->z[r],
                                        last->tangent[r]);
    }
    SM_TRY(correct(curve, FOLLOWING, guess, last->tangent, last->tangent, found));
    const double turn = sm_dot((size_t)n, found->tangent, last->tangent);
    return turn < cos(LARGEST_TURN) && step > SIGNIFICANT_STEP * curve->noise ? SM_NOT_CONVERGED
                                                                              : SM_OK;
}

/* Traces the curve from a start along its tangent; returns the number of points, at most `most`. */
static size_t trace(const sm_curve *curve, const point *start, size_t most, rows out,
                     int *closed) {
    const int k = curve->unknowns, n = k + 1;
    point before, last = *start, next;
    double step = FIRST_STEP * curve->largest_step;
    size_t count = 1;
    int far = 0;
    put(curve, out, 0, start);
    while (count < most) {
        if (predict_and_correct(curve, count > 1 ? &before : NULL, &last, step, &next) != SM_OK) {
            step *= 0.5;
            if (step < fmax(SHORTEST_STEP, 0.25 * SIGNIFICANT_STEP * curve->noise)) break;
            continue;
        }
        if (next.z[k] < 0.0 || next.z[k] > 1.0) {
            point end;
            if (end_point(curve, &last, &next, &end) == SM_OK
                && distance(n, end.z, last.z) > SHORTEST_STEP)
                put(curve, out, count++, &end);
            break;
        }
        if (next.iterations <= EASY_ITERATIONS) step = fmin(GROWTH * step, curve->largest_step);
        put(curve, out, count++, &next);
        const double away = distance(n, next.z, start->z);
        if (far && away < step && sm_dot((size_t)n, next.tangent, start->tangent) > 0.0) {
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
    SM_TRY(correct(curve, FOLLOWING, start, upwards, upwards, &at));
    double *middle = points + (ptrdiff_t)(most - 1) * row;
    const rows onwards = {middle, row, 1.0}, back = {middle, -row, -1.0};
    int closed = 0;
    branch->after = trace(curve, &at, most, onwards, &closed) - 1;
    branch->before = 0;
    branch->closed = closed;
    if (branch->closed) return SM_OK;
    for (int i = 0; i < n; i++) at.tangent[i] = -at.tangent[i];
    branch->before = trace(curve, &at, most, back, &closed) - 1;
    return SM_OK;
}

sm_status sm_curve_point_near(const sm_curve *curve, const double *guess, const double *normal,
                              const double *onward, double *row) {
    if (!is_valid(curve) || !guess || !normal || !onward || !row) return SM_BAD_ARGUMENT;
    point found;
    const sm_status status = correct(curve, BISECTING, guess, normal, onward, &found);
    if (status == SM_OK) put(curve, (rows){row, 0, 1.0}, 0, &found);
    return status;
}

sm_status sm_curve_solved(const sm_curve *curve, double *z) {
    if (!is_valid(curve) || !z) return SM_BAD_ARGUMENT;
    const int k = curve->unknowns;
    double upwards[MOST + 1] = {0.0};
    point found;
    upwards[k] = 1.0;
    const sm_status status = correct(curve, SEARCHING, z, upwards, upwards, &found);
    if (status == SM_OK) memcpy(z, found.z, ((size_t)k + 1) * sizeof *z);
    return status;
}
